"""The axes of a rig: which way is up, and which way it faces."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..errors import SampError
from .rig import Rig

SNAP = np.radians(
    15.0
)  # deviation of a body's axes from the armature's up to which they are taken for the same


def body_axes(rig: Rig, at: Mapping[str, int]) -> np.ndarray:
    """Return the rotation (3, 3) from network axes to the armature's own: +Y from feet to head, +X from right to left.

    at: joint -> index of its bone. Raises SampError where left and right are exchanged or coincide.
    """
    middle = lambda joint: (rig.heads[at[f"left_{joint}"]] + rig.heads[at[f"right_{joint}"]]) / 2
    up = _snap(middle("shoulder") - middle("ankle"))
    side = sum(
        rig.heads[at[f"left_{joint}"]] - rig.heads[at[f"right_{joint}"]] for joint in ("hip", "shoulder")
    )
    side = side - (side @ up) * up
    if np.linalg.norm(side) < 1e-9:
        raise SampError(f"Left and right of '{rig.name}' coincide; correct its bone table.")
    side = _snap(side)
    side = side - (side @ up) * up
    side /= np.linalg.norm(side)
    axes = np.stack([side, up, np.cross(side, up)], axis=1)
    toes = [
        rig.heads[at[f"{s}_foot"]] - rig.heads[at[f"{s}_ankle"]]
        for s in ("left", "right")
        if f"{s}_foot" in at
    ]
    if toes and sum(toes) @ axes[:, 2] < 0:
        raise SampError(
            f"The feet of '{rig.name}' point backwards; left and right are exchanged in its bone table."
        )
    return axes


def _snap(direction: np.ndarray) -> np.ndarray:
    """Return the unit vector of a direction (3,), snapped to a coordinate axis nearby."""
    unit = direction / np.linalg.norm(direction)
    k = int(np.argmax(np.abs(unit)))
    if np.abs(unit[k]) < np.cos(SNAP):
        return unit
    axis = np.zeros(3)
    axis[k] = np.sign(unit[k])
    return axis
