"""All captured motion as one array of frames, with the features of motion matching."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d, uniform_filter1d

from ....samp_addon import rotation, skeleton
from ....samp_addon.frames import wrap_angle
from ...mocap import clip_files, natural
from ...mocap.clip_files import FPS, Clip
from ...mocap.events import headings
from ...mocap.posture import neutralised

SETS = ("smplx30", "rocketbox30", "o3de30", "accad30")
SMOOTH = 8.0  # frames, sigma that removes the sway of single steps from a path
AHEAD = (10, 20, 30)  # future frames at which routes are compared
UPRIGHT = np.radians(
    16.5
)  # largest mean rotation of the knee joints in a standing that is played; flexion is about 4 degrees less
LEAD, TAIL = 3, 32  # frames of the same clip required before and after a match
LABELS = ("other", "idle", "shift", "walk", "run", "sit_down", "sit", "stand_up", "lie_down", "lie", "get_up")
LOCOMOTION = ("idle", "shift", "walk")
# Acted walks and stands that are unusual in rooms; crouches, jumps and props.
ACTED = (
    "drunk", "injured", "bruised", "cool", "Crouch", "crouch", "Jump", "OutofRange", "trolley", "umbrella", "knock",
    "_door", "cheer", "angry", "hold_bag", "Kick", "Lie", "lie", "box", "Box", "clap", "take_picture", "work_",
)  # fmt: skip
# Columns of the features and their weights: feet, their velocities, the pelvis' velocity, route and facing ahead.
BLOCKS = (
    ("feet", 6, 0.8),
    ("feet speed", 6, 0.9),
    ("pelvis speed", 3, 1.0),
    ("route", 6, 1.3),
    ("facing", 6, 1.6),
)
POSE = 15  # number of columns that describe the pose; the others describe the route ahead


@dataclass(frozen=True)
class Bank:
    """The N frames of all clips, concatenated.

    root: (N, 3). rotations: (N, 22, 4). flat: (N, 3) x, z and yaw of the root without the sway of steps. yaw is
    unwrapped in each clip. labels: (N,) indices into LABELS. feet: (N, 2) contacts of right and left foot. clip:
    (N,) number of the clip; names: of the clips. rows: (M,) frames that can be matched; features: (M, 27), scaled;
    scale, middle: (27,) of the features. pose: (N, 15) scaled pose features of all frames. ahead, still: (N,) usable
    frames that follow each, and usable frames of standing that do.
    """

    root: np.ndarray
    rotations: np.ndarray
    flat: np.ndarray
    labels: np.ndarray
    feet: np.ndarray
    clip: np.ndarray
    names: list[str]
    rows: np.ndarray
    features: np.ndarray
    middle: np.ndarray
    scale: np.ndarray
    pose: np.ndarray
    ahead: np.ndarray
    still: np.ndarray

    @cached_property
    def upright(self) -> np.ndarray:
        """Flags (N,) of frames with straight knees: mean rotation over a second of at most UPRIGHT."""
        knees = self.rotations[:, [skeleton.INDEX["left_knee"], skeleton.INDEX["right_knee"]], 0]
        flexion = 2 * np.arccos(np.clip(np.abs(knees), 0, 1)).mean(1)
        return uniform_filter1d(flexion, FPS) < UPRIGHT

    def trajectory(self, places: np.ndarray, facing: np.ndarray) -> np.ndarray:
        """Return scaled features (K, 12) of a wanted route.

        places: (K, 3, 2) metres to the left of and ahead of the root. facing: (K, 3) radians.
        """
        direction = np.stack([np.sin(facing), np.cos(facing)], -1)
        raw = np.concatenate([places.reshape(-1, 6), direction.reshape(-1, 6)], -1)
        return (raw - self.middle[POSE:]) * self.scale[POSE:]


def load(folder: Path, sets: tuple[str, ...] = SETS) -> tuple[Bank, list[Clip]]:
    """Return the bank of the clips in sub-folders of ``folder`` and their mirror images, and those clips."""
    clips: list[Clip] = []
    for name in sets:
        clips += neutralised(clip_files.load_clips(Path(folder) / name))
    clips += [clip_files.mirror(clip) for clip in clips]
    return build(clips), clips


def build(clips: list[Clip]) -> Bank:
    """Return the bank of clips."""
    parts = [_features(clip) for clip in clips]
    cat = lambda k: np.concatenate([part[k] for part in parts])
    flat, raw, usable = cat(0), cat(1), cat(2)
    number = np.repeat(np.arange(len(clips)), [len(clip) for clip in clips])
    rows = np.flatnonzero(usable)[::2]
    chosen = raw[rows].astype(np.float64)
    middle = chosen.mean(0)
    # One scale for each block, which preserves directions within it.
    scale, at = np.empty(chosen.shape[1]), 0
    for _, size, weight in BLOCKS:
        spread = chosen[:, at : at + size].std(0).mean()
        scale[at : at + size] = weight / max(spread, 1e-6) / np.sqrt(size)
        at += size
    index = {label: k for k, label in enumerate(LABELS)}
    return Bank(
        root=np.concatenate([clip.root for clip in clips]),
        rotations=np.concatenate([clip.rotations for clip in clips]).astype(np.float32),
        flat=flat,
        labels=np.concatenate([[index[label] for label in clip.labels] for clip in clips]).astype(np.uint8),
        feet=np.concatenate([clip.feet for clip in clips]).astype(np.float32),
        clip=number,
        names=[clip.name for clip in clips],
        rows=rows,
        features=((chosen - middle) * scale).astype(np.float32),
        middle=middle,
        scale=scale,
        pose=((raw[:, :POSE] - middle[:POSE]) * scale[:POSE]).astype(np.float32),
        ahead=cat(3),
        still=cat(4),
    )


def _features(clip: Clip) -> tuple[np.ndarray, ...]:
    """Return flat root (T, 3), raw features (T, 27), flags of matchable frames (T,), numbers of usable frames after
    each (T,), and those of standing (T,)."""
    flat = flat_root(clip.root, clip.rotations)
    count = len(clip)
    raw = np.zeros((count, sum(size for _, size, _ in BLOCKS)))
    raw[:, :POSE] = _pose(clip.root, clip.rotations, flat)
    back = np.stack([np.cos(flat[:, 2]), np.sin(flat[:, 2])], -1)
    for k, step in enumerate(AHEAD):
        later = np.minimum(np.arange(count) + step, count - 1)
        away, turn = flat[later, :2] - flat[:, :2], flat[later, 2] - flat[:, 2]
        raw[:, POSE + 2 * k] = away[:, 0] * back[:, 0] - away[:, 1] * back[:, 1]
        raw[:, POSE + 2 * k + 1] = away[:, 0] * back[:, 1] + away[:, 1] * back[:, 0]
        raw[:, POSE + 6 + 2 * k] = np.sin(turn)
        raw[:, POSE + 6 + 2 * k + 1] = np.cos(turn)
    marked = natural.astray_marked(clip)
    fit = np.isin(clip.labels, LOCOMOTION) & ~marked.bad
    if natural.styled(clip) or any(word in clip.name for word in ACTED):
        fit[:] = False
    # Smoothing distorts the path near a clip's ends.
    ahead = np.maximum(_runs_on(fit) - 4, 0)
    still = np.minimum(_runs_on(np.isin(clip.labels, ("idle", "shift")) & ~_wanders(flat)), ahead)
    steady = minimum_filter1d(fit.astype(np.uint8), 2 * LEAD + 1, mode="constant").astype(bool)
    usable = steady & (ahead >= TAIL)
    usable[: 2 * LEAD] = False
    return flat, raw, usable, ahead, still


def _runs_on(flags: np.ndarray) -> np.ndarray:
    """Return the number of frames (T,) for which flags (T,) stay true from each frame on."""
    ends = np.flatnonzero(~np.concatenate([flags, [False]]))
    at = np.arange(len(flags))
    return ends[np.searchsorted(ends, at)] - at


def _wanders(flat: np.ndarray) -> np.ndarray:
    """Flag frames (T,) in which the smoothed root moves faster than when shifting weight."""
    speed = np.linalg.norm(np.gradient(flat[:, :2], 1 / FPS, axis=0), axis=-1)
    return speed > 0.22


def flat_root(root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return a body's route (T, 3), x, z (metres) and unwrapped yaw (radians), without the sway of its steps."""
    yaw = np.unwrap(headings(root, rotations.astype(np.float64)))
    return gaussian_filter1d(np.column_stack([root[:, [0, 2]], yaw]), SMOOTH, axis=0, mode="nearest")


_WATCHED = [skeleton.INDEX["left_foot"], skeleton.INDEX["right_foot"]]


def _pose(root: np.ndarray, rotations: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Return raw pose features (T, 15)."""
    rotations = rotations.astype(np.float64)
    joints, _ = skeleton.forward_kinematics(root, rotations, skeleton.default_rest_joints())
    yaw = flat[:, 2]
    velocity = np.gradient(joints[:, [*_WATCHED, 0]], 1 / FPS, axis=0)
    local = joints[:, _WATCHED] - root[:, None] * np.array([1.0, 0.0, 1.0])
    turn = np.broadcast_to(rotation.about_y(-yaw)[:, None], (len(root), 3, 4))
    place = rotation.rotate(turn[:, :2], local).reshape(len(root), -1)
    speed = rotation.rotate(turn, velocity).reshape(len(root), -1)
    return np.concatenate([place, speed], -1)


def pose_of(bank: Bank, root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return scaled pose features (T, 15) of a motion outside the bank: root (T, 3), rotations (T, 22, 4)."""
    raw = _pose(root, rotations, flat_root(root, rotations))
    return (raw - bank.middle[:POSE]) * bank.scale[:POSE]


def turned_flat(flat: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return a route (T, 3) of x, z, yaw, moved so that its first frame is at ``start`` (3,)."""
    turn = wrap_angle(start[2] - flat[0, 2])
    c, s = np.cos(turn), np.sin(turn)
    away = flat[:, :2] - flat[0, :2]
    x, z = away[:, 0] * c + away[:, 1] * s, -away[:, 0] * s + away[:, 1] * c
    return np.column_stack([start[0] + x, start[1] + z, start[2] + flat[:, 2] - flat[0, 2]])
