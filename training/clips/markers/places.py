"""Positions of the markers of common full-body sets on the default human.

A position is found on the skin: from an anchor in the rest pose (T-pose, +Z forward, left is +X) along a direction.
Left markers are listed; right ones mirror them. Names are those of Vicon's sets, as used by the CMU and ACCAD
databases.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from ....samp_addon import skeleton
from ....samp_addon.body import human

RADIUS = 0.010  # metres from the skin to a marker's centre
ALIASES = {"LFWT": "LASI", "RFWT": "RASI", "LBWT": "LPSI", "RBWT": "RPSI", "LSHN": "LTIB", "RSHN": "RTIB",
           "LHEEL": "LHEE", "RHEEL": "RHEE", "RBAK": "RBAC", "RBACK": "RBAC", "LWRI": "LWRA", "RWRI": "RWRA",
           "LMT1": "LTOE", "RMT1": "RTOE"}  # fmt: skip
# marker: bone it moves with, anchor (joint, or two joints and the share between), offset of the anchor, direction
_MIDDLE = {
    "C7": ("spine3", ("neck",), (0, 0, 0), (0, 0.2, -1)),
    "T10": ("spine3", ("spine3",), (0, 0, 0), (0, 0, -1)),
    "CLAV": ("spine3", ("neck",), (0, -0.06, 0), (0, 0, 1)),
    "STRN": ("spine3", ("spine3",), (0, 0, 0), (0, 0, 1)),
    "RBAC": ("spine3", ("spine3",), (-0.09, 0.08, 0), (0, 0, -1)),
    "SACR": ("pelvis", ("pelvis",), (0, 0.05, 0), (0, 0, -1)),
}
_LEFT = {
    "FHD": ("head", ("head",), (0.03, 0.13, 0.03), (0.55, 0, 0.85)),
    "BHD": ("head", ("head",), (0.03, 0.13, -0.02), (0.55, 0, -0.85)),
    "SHO": ("left_collar", ("left_shoulder",), (0, 0, 0), (0, 1, 0)),
    "UPA": ("left_shoulder", ("left_shoulder", "left_elbow", 0.55), (0, 0, 0), (0, 1, 0)),
    "ELB": ("left_shoulder", ("left_elbow",), (0, 0, 0), (0, 1, 0)),
    "FRM": ("left_elbow", ("left_elbow", "left_wrist", 0.5), (0, 0, 0), (0, 1, 0)),
    "WRA": ("left_elbow", ("left_wrist",), (0, 0, 0), (0, 0.3, 1)),
    "WRB": ("left_elbow", ("left_wrist",), (0, 0, 0), (0, 0.3, -1)),
    "FIN": ("left_wrist", ("left_middle1",), (0, 0, 0), (0, 1, 0)),
    "ASI": ("pelvis", ("left_hip",), (0.02, 0.11, 0), (0.3, 0, 1)),
    "PSI": ("pelvis", ("pelvis",), (0.045, 0.07, 0), (0.1, 0, -1)),
    "THI": ("left_hip", ("left_hip", "left_knee", 0.6), (0, 0, 0), (1, 0, 0)),
    "KNE": ("left_hip", ("left_knee",), (0, 0, 0), (1, 0, 0)),
    "TIB": ("left_knee", ("left_knee", "left_ankle", 0.5), (0, 0, 0), (1, 0, 0)),
    "ANK": ("left_knee", ("left_ankle",), (0, 0, 0), (1, 0, 0)),
    "HEE": ("left_ankle", ("left_ankle",), (0, -0.03, 0), (0, 0, -1)),
    "TOE": ("left_ankle", ("left_foot",), (0, 0, 0), (0, 1, 0)),
    "MT5": ("left_ankle", ("left_foot",), (0, -0.005, -0.01), (1, 0, 0)),
}
MIRROR = np.array([-1.0, 1.0, 1.0])


@functools.cache
def places() -> dict[str, tuple[int, np.ndarray]]:
    """Return marker -> joint whose bone it moves with, and its offset (3,) from it in the rest pose, metres."""
    body = human.load()
    joints = body.joints - body.joints[0]
    found = {}
    for name, (bone, anchor, offset, direction) in _MIDDLE.items():
        found[name] = _placed(body.vertices, joints, bone, anchor, offset, direction)
    for name, (bone, anchor, offset, direction) in _LEFT.items():
        joint, place = _placed(body.vertices, joints, bone, anchor, offset, direction)
        found["L" + name] = joint, place
        other = skeleton.INDEX[skeleton.JOINTS[joint].replace("left", "right")]
        found["R" + name] = other, place * MIRROR
    return found


def known(names: Sequence[str]) -> dict[str, int]:
    """Return marker -> column, for those names of a file that have a known position."""
    found: dict[str, int] = {}
    for column, name in enumerate(names):
        meant = ALIASES.get(name, name)
        if meant in places():
            found.setdefault(meant, column)
    return found


def _placed(
    vertices: np.ndarray,
    joints: np.ndarray,
    bone: str,
    anchor: tuple,
    offset: Sequence[float],
    direction: Sequence[float],
) -> tuple[int, np.ndarray]:
    at = lambda name: joints[skeleton.INDEX[name]]
    start = at(anchor[0]) + np.array(offset, dtype=np.float64)
    if len(anchor) == 3:
        start = start + anchor[2] * (at(anchor[1]) - at(anchor[0]))
    way = np.array(direction, dtype=np.float64) / np.linalg.norm(direction)
    along = (vertices - start) @ way
    aside = np.linalg.norm(vertices - start - along[:, None] * way, axis=-1)
    # The nearest skin in that direction; farther away, the line may leave one limb and enter another.
    score = np.where((along > 0) & (along < 0.25), aside, np.inf)
    k = int(np.argmin(score))
    surface = start + along[k] * way
    return skeleton.INDEX[bone], surface + RADIUS * way - at(bone)
