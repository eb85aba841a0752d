"""Measure clips before training: knee and elbow flexion, sliding feet, joint limits, jerk.

Measures of a set are pooled over the frames of its clips, and printed beside those of other sets.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ...samp_addon import rotation, skeleton
from ...samp_addon.evaluation import feet
from ...samp_addon.motion import Motion
from .retarget import twist

WANTED = {"knee idle": 19.0, "knee walk": 33.0, "knee straightest": 10.0}
"""Upper limits, degrees, of a set's median knee flexion, idle and walking, and of its straightest twentieth; above
them the set teaches networks to crouch."""

COLUMNS = (
    "clips", "minutes", "knee idle", "knee walk", "knee straightest", "elbow idle", "elbow walk", "elbow straightest",
    "step width m", "foot slide cm/s", "stance slide cm/s", "stance share", "beyond limits %", "jerk idle",
    "jerk sit", "jerk walk", "jerk run", "glitch %",
)  # fmt: skip
_SWING = {"wrist": 85, "ankle": 60, "neck": 55, "head": 55, "spine1": 55, "spine2": 55, "spine3": 55, "hip": 140,
          "shoulder": 150, "collar": 50}  # fmt: skip
"""Largest rotation of a joint from the zero pose, degrees; for wrists without the twist about the bone."""

KNEE, KNEE_SIDE, ELBOW, ELBOW_BACK, WRIST_TWIST = (-10, 160), 35, 165, 25, 75


def flexion(positions: np.ndarray, middle: str, side: str) -> np.ndarray:
    """Return the flexion (T,), degrees, of a "knee" or an "elbow" (middle); 0 is straight. positions: (T, J, 3)."""
    limb = {"knee": ("hip", "knee", "ankle"), "elbow": ("shoulder", "elbow", "wrist")}[middle]
    a, b, c = (positions[:, skeleton.INDEX[f"{side}_{joint}"]] for joint in limb)
    upper, lower = b - a, c - b
    cosine = np.sum(upper * lower, -1) / (np.linalg.norm(upper, axis=-1) * np.linalg.norm(lower, axis=-1))
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def step_width(positions: np.ndarray) -> np.ndarray:
    """Return the distance (T,) of the ankles along the line of the hips, metres; positions: (T, J, 3)."""
    at = lambda joint: positions[:, skeleton.INDEX[joint]]
    across = (at("left_hip") - at("right_hip")) * np.array([1.0, 0.0, 1.0])
    across = across / np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-9)
    return np.abs(np.sum((at("left_ankle") - at("right_ankle")) * across, -1))


def beyond_limits(rotations: np.ndarray) -> np.ndarray:
    """Flag frames (T,) in which a joint of rotations (T, 22, 4) exceeds its anatomical limits."""
    rotations = np.where(rotations[..., :1] < 0, -rotations, rotations)
    angle = np.degrees(2 * np.arccos(np.clip(rotations[..., 0], -1, 1)))
    bad = np.zeros(len(rotations), bool)
    rest = skeleton.default_rest_joints()
    for j, name in enumerate(skeleton.BODY_JOINTS):
        part = name.split("_")[-1]
        local = rotations[:, j]
        if part == "knee":
            bend = np.degrees(twist(local, np.array([1.0, 0.0, 0.0])))
            hinge = rotation.from_axis_angle(np.radians(bend)[:, None] * np.array([1.0, 0.0, 0.0]))
            off = rotation.multiply(local, rotation.conjugate(hinge))
            bad |= (bend < KNEE[0]) | (bend > KNEE[1])
            bad |= np.degrees(2 * np.arccos(np.clip(np.abs(off[:, 0]), 0, 1))) > KNEE_SIDE
        elif part == "elbow":
            bone = rest[skeleton.INDEX[name.replace("elbow", "wrist")]] - rest[j]
            bone = bone / np.linalg.norm(bone)
            way = rotation.rotate(local, np.broadcast_to(bone, (len(local), 3)))
            bad |= np.degrees(np.arccos(np.clip(way @ bone, -1, 1))) > ELBOW
            bad |= way[:, 2] < bone[2] - np.sin(np.radians(ELBOW_BACK))
        elif part in _SWING:
            turned = angle[:, j]
            if part == "wrist":
                bone = rest[j] - rest[skeleton.PARENTS[j]]
                bone = bone / np.linalg.norm(bone)
                about = twist(local, bone)
                swing = rotation.multiply(
                    local, rotation.conjugate(rotation.from_axis_angle(about[:, None] * bone))
                )
                turned = np.degrees(2 * np.arccos(np.clip(np.abs(swing[:, 0]), 0, 1)))
                bad |= np.abs(np.degrees(about)) > WRIST_TWIST
            bad |= turned > _SWING[part]
    return bad


class Quality:
    """The measures of a set, accumulated clip by clip."""

    def __init__(self) -> None:
        self._frames: dict[str, list[np.ndarray]] = defaultdict(list)
        self._means: list[tuple[int, dict[str, float | None]]] = []
        self._clips = 0

    def add(self, motion: Motion, labels: np.ndarray, glitch: np.ndarray) -> None:
        """Add a clip with its labels (T,) and flags of pops (T,)."""
        self._clips += 1
        positions, _ = motion.forward_kinematics()
        sound = ~np.asarray(glitch, bool)
        upright = np.isin(labels, ("idle", "shift", "walk")) & sound
        for middle in ("knee", "elbow"):
            for side in ("left", "right"):
                angles = flexion(positions, middle, side)
                for label in ("idle", "walk"):
                    self._frames[f"{middle} {label}"].append(angles[(labels == label) & sound])
                self._frames[f"{middle} straightest"].append(angles[upright])
        self._frames["step width m"].append(step_width(positions)[(labels == "walk") & sound])
        self._frames["beyond limits %"].append(
            100.0 * beyond_limits(motion.rotations[:, : skeleton.BODY_COUNT])
        )
        self._frames["glitch %"].append(100.0 * np.asarray(glitch, float))
        if len(motion) > 3:
            third = np.diff(positions[:, : skeleton.BODY_COUNT], 3, axis=0)
            jerk = np.linalg.norm(third, axis=-1) * motion.fps**3
            for label in ("idle", "sit", "walk", "run"):
                self._frames[f"jerk {label}"].append(jerk[((labels == label) & sound)[2:-1]].ravel())
        self._means.append((len(motion), feet.measures(motion)))

    def numbers(self) -> dict[str, float | None]:
        """Return one number for each of COLUMNS; None where no frame shows it."""
        measures: dict[str, float | None] = {"clips": self._clips}
        measures["minutes"] = sum(count for count, _ in self._means) / 1800
        for name, parts in self._frames.items():
            frames = np.concatenate(parts)
            if name.endswith("straightest"):
                pool = lambda x: np.percentile(x, 5)
            elif name.startswith("jerk"):
                pool = lambda x: np.percentile(x, 99)
            elif name.endswith("%"):
                pool = np.mean
            else:
                pool = np.median
            measures[name] = float(pool(frames)) if len(frames) else None
        for name, key in (("foot slide cm/s", "foot_slide_cm_s"), ("stance slide cm/s", "stance_slide_cm_s"),
                          ("stance share", "stance_share")):  # fmt: skip
            # A clip's stance slide is weighted by its share of stances.
            pairs = [
                (count * (one["stance_share"] if "slide cm" in name and "stance" in name else 1.0), one[key])
                for count, one in self._means
                if one[key] is not None
            ]
            weight = sum(w for w, _ in pairs)
            measures[name] = sum(w * value for w, value in pairs) / weight if weight else None
        return {name: measures.get(name) for name in COLUMNS}


def of_folder(folder: Path) -> dict[str, float | None]:
    """Return the measures of a folder of clips."""
    quality = Quality()
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as data:
            quaternions = rotation.normalise(data["local_quat_wxyz"].astype(np.float64))
            motion = Motion(data["root_pos"].astype(np.float64), quaternions, float(data["fps"]))
            quality.add(motion, data["label_names"][data["label"]].astype(str), data["glitch"] > 0)
    return quality.numbers()


def faults(numbers: Mapping[str, float | None]) -> list[str]:
    """Return one sentence for each measure of a set that exceeds the limits of captured people."""
    return [
        f"{name} is {value:.1f} degrees; captured people stay under {most:.0f}."
        for name, most in WANTED.items()
        if (value := numbers.get(name)) is not None and value > most
    ]


def table(sets: Sequence[tuple[str, Mapping[str, float | None]]]) -> str:
    """Return the measures of sets as a Markdown table with one column for each set."""
    lines = [_row(["measure", *(name for name, _ in sets)]), _row(["---"] * (len(sets) + 1))]
    for column in COLUMNS:
        lines.append(_row([column, *(_number(column, numbers.get(column)) for _, numbers in sets)]))
    return "\n".join(lines)


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _number(column: str, value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.0f}" if column == "clips" or column.startswith("jerk") else f"{value:.2f}"
