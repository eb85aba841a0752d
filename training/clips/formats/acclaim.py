"""Acclaim files: a skeleton (.asf) and motions on it (.amc), as the CMU database has them.

A bone rotates about its own axes: with C the rotation of those axes, the rotation from the rest pose is C R C^-1.
Its joint is at its start, so the joint of "lfemur" is the left hip.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ....samp_addon import rotation
from ....samp_addon.errors import SampError
from ..recording import Recording, of_local

FPS = 120.0
"""Frames a second of an AMC file, which does not store its rate; that of the CMU database is 120."""


@dataclass
class _Bone:
    name: str
    direction: np.ndarray = field(default_factory=lambda: np.zeros(3))
    length: float = 0.0
    axes: np.ndarray = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    channels: list[str] = field(default_factory=list)
    parent: str = ""

    @property
    def vector(self) -> np.ndarray:
        """Vector (3,) from the bone's joint to its end, in the rest pose."""
        return self.direction / (np.linalg.norm(self.direction) or 1.0) * self.length


def read(path: Path, fps: float = FPS) -> Recording:
    """Return the motion of an .amc file on the skeleton beside it.

    The skeleton is the .asf of the same name, of the name's first part (07_01.amc: 07.asf), or the only one in the
    folder. Raise SampError where there is none, or where either file cannot be read.
    """
    asf = skeleton_of(path)
    try:
        bones, unit = _skeleton(asf.read_text(errors="replace"))
        frames = _frames(path.read_text(errors="replace"))
    except (ValueError, IndexError, KeyError) as error:
        raise SampError(
            f"'{path.name}' with '{asf.name}' is not readable as ASF and AMC: {error}."
        ) from error
    if not frames:
        raise SampError(f"'{path.name}' contains no motion.")
    order = _ordered(bones)
    place = {name: k for k, name in enumerate(order)}
    parents = [place[bones[name].parent] if bones[name].parent else -1 for name in order]
    # A joint lies at the end of the parent bone.
    offsets = np.array([bones[order[p]].vector if p >= 0 else np.zeros(3) for p in parents])
    local = np.tile([1.0, 0.0, 0.0, 0.0], (len(frames), len(order), 1))
    moved = np.tile(offsets, (len(frames), 1, 1))
    for j, name in enumerate(order):
        bone = bones[name]
        values = np.array([frame.get(name, [0.0] * len(bone.channels)) for frame in frames])
        turn = np.tile([1.0, 0.0, 0.0, 0.0], (len(frames), 1))
        for column, channel in enumerate(bone.channels):
            axis = "xyz".index(channel[1])
            if channel[0] == "t":
                moved[:, j, axis] = values[:, column]
            elif channel[0] == "r":
                angles = values[:, column, None] * unit * np.eye(3)[axis]
                turn = rotation.multiply(rotation.from_axis_angle(angles), turn)
        local[:, j] = rotation.multiply(rotation.multiply(bone.axes, turn), rotation.conjugate(bone.axes))
    ends = np.array([bones[name].vector for name in order])
    return of_local(path.stem, fps, order, parents, offsets, local, moved, ends)


def skeleton_of(path: Path) -> Path:
    """Return the .asf file of an .amc file. Raise SampError where it is ambiguous."""
    for name in (path.stem, path.stem.split("_")[0]):
        if (path.parent / f"{name}.asf").exists():
            return path.parent / f"{name}.asf"
    found = sorted(path.parent.glob("*.asf"))
    if len(found) != 1:
        raise SampError(
            f"'{path.name}' needs the .asf file of its skeleton in the same folder, under the same name."
        )
    return found[0]


def _skeleton(text: str) -> tuple[dict[str, _Bone], float]:
    """Return the bones by name, root first, and the file's unit of angle in radians."""
    bones = {"root": _Bone("root", channels=["tx", "ty", "tz", "rx", "ry", "rz"])}
    unit = np.radians(1.0)
    section, bone = "", None
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if not words:
            continue
        key, values = words[0].lower(), words[1:]
        if key.startswith(":"):
            section = key
        elif section == ":units" and key == "angle":
            unit = 1.0 if values[0].lower().startswith("rad") else np.radians(1.0)
        elif section == ":root" and key == "order":
            bones["root"].channels = [value.lower() for value in values]
        elif section == ":bonedata":
            bone = _bone_line(key, values, bone, bones, unit)
        elif section == ":hierarchy" and key not in ("begin", "end"):
            for child in values:
                bones[child].parent = words[0]
    return bones, unit


def _bone_line(
    key: str, values: list[str], bone: _Bone | None, bones: dict[str, _Bone], unit: float
) -> _Bone | None:
    """Parse one line of a bone's description; return the bone that it describes."""
    if key == "begin":
        return _Bone("")
    if bone is None:
        return None
    if key == "name":
        bone.name = values[0]
        bones[bone.name] = bone
    elif key == "direction":
        bone.direction = np.array(values[:3], dtype=np.float64)
    elif key == "length":
        bone.length = float(values[0])
    elif key == "axis":
        bone.axes = _turned(np.array(values[:3], dtype=np.float64) * unit, values[3].lower())
    elif key == "dof":
        bone.channels = [value.lower() for value in values]
    return bone


def _turned(angles: np.ndarray, order: str) -> np.ndarray:
    """Return the quaternion (4,) of angles (3,), radians, about fixed axes, in the order of the letters."""
    result = np.array([1.0, 0.0, 0.0, 0.0])
    for letter, angle in zip(order, angles, strict=True):
        turn = rotation.from_axis_angle(angle * np.eye(3)["xyz".index(letter)])
        result = rotation.multiply(turn, result)
    return result


def _ordered(bones: dict[str, _Bone]) -> list[str]:
    """Return the names, parents before children."""
    order, left = ["root"], [name for name in bones if name != "root"]
    while left:
        ready = [name for name in left if bones[name].parent in order]
        if not ready:
            raise ValueError(f"bone {left[0]} has no parent")
        order += ready
        left = [name for name in left if name not in ready]
    return order


def _frames(text: str) -> list[dict[str, list[float]]]:
    """Return, for each frame, the values of each bone by name."""
    frames: list[dict[str, list[float]]] = []
    for line in text.splitlines():
        words = line.split()
        if not words or words[0][0] in ":#":
            continue
        if len(words) == 1 and words[0].isdigit():
            frames.append({})
        elif frames:
            frames[-1][words[0]] = [float(word) for word in words[1:]]
    return frames
