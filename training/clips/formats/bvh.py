"""Biovision hierarchy files (.bvh): a skeleton of offsets, and Euler angles in the order that each joint names."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ....samp_addon import rotation
from ....samp_addon.errors import SampError
from ..recording import Recording, of_local


@dataclass
class _Joint:
    name: str
    parent: int
    offset: list[float] = field(default_factory=list)
    channels: list[str] = field(default_factory=list)
    ends: list[list[float]] = field(default_factory=list)


def read(path: Path) -> Recording:
    """Return the motion of a .bvh file. Raise SampError where it cannot be read."""
    words = path.read_text(encoding="utf-8", errors="replace").split()
    try:
        split = words.index("MOTION")
        joints = _hierarchy(words[:split])
        count, step = int(words[split + 2]), float(words[split + 5])
        values = np.array(words[split + 6 :], dtype=np.float64)
        width = sum(len(joint.channels) for joint in joints)
        values = values[: count * width].reshape(count, width)
    except (ValueError, IndexError) as error:
        raise SampError(f"'{path.name}' is not a readable BVH file: {error}.") from error
    if count < 1 or step <= 0:
        raise SampError(f"'{path.name}' contains no motion.")
    offsets = np.array([joint.offset for joint in joints])
    local, moved = _channels(joints, values, offsets)
    below = [
        joint.ends + [other.offset for other in joints if other.parent == k] for k, joint in enumerate(joints)
    ]
    ends = np.array([np.mean(one, axis=0) if one else np.zeros(3) for one in below])
    names, parents = [joint.name for joint in joints], [joint.parent for joint in joints]
    return of_local(path.stem, 1 / step, names, parents, offsets, local, moved, ends)


def _hierarchy(words: list[str]) -> list[_Joint]:
    """Return the joints, parents before children."""
    joints: list[_Joint] = []
    open_ = [-1]
    k = 0
    while k < len(words):
        word = words[k]
        if word in ("ROOT", "JOINT"):
            stop = words.index("{", k)
            joints.append(_Joint("_".join(words[k + 1 : stop]), open_[-1]))
            open_.append(len(joints) - 1)
            k = stop
        elif word == "End":
            open_.append(-2 - open_[-1])  # below zero: the end site of joint -2 - value
            k = words.index("{", k)
        elif word == "OFFSET":
            offset = [float(value) for value in words[k + 1 : k + 4]]
            if open_[-1] >= 0:
                joints[open_[-1]].offset = offset
            else:
                joints[-2 - open_[-1]].ends.append(offset)
            k += 3
        elif word == "CHANNELS":
            count = int(words[k + 1])
            joints[open_[-1]].channels = words[k + 2 : k + 2 + count]
            k += 1 + count
        elif word == "}":
            open_.pop()
        k += 1
    if not joints:
        raise ValueError("no joints")
    return joints


def _channels(joints: list[_Joint], values: np.ndarray, offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return local rotations (T, J, 4) and offsets (T, J, 3) from channel values (T, channels).

    Position channels replace the offset of the hierarchy; they are not added to it.
    """
    local = np.tile([1.0, 0.0, 0.0, 0.0], (len(values), len(joints), 1))
    moved = np.tile(offsets, (len(values), 1, 1))
    at = 0
    for j, joint in enumerate(joints):
        for channel in joint.channels:
            axis = "XYZ".index(channel[0].upper())
            if channel[1:].lower() == "position":
                moved[:, j, axis] = values[:, at]
            else:
                turn = np.radians(values[:, at, None]) * np.eye(3)[axis]
                local[:, j] = rotation.multiply(local[:, j], rotation.from_axis_angle(turn))
            at += 1
    return local, moved
