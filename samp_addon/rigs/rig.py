"""A rig in its rest pose, as read from an armature."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, eq=False)
class Rig:
    """Bones in the order of the armature, in its own axes and units.

    name: of the armature. names: (B,) of the bones. parents: (B,) indices, -1 for none. heads, tails: (B, 3).
    bases: (B, 3, 3) rest rotations. constrained: (B,) whether constraints may move a bone. inherits: (B,)
    whether it turns with its parent. world: (4, 4) of the armature; turn: (3, 3) its rotation, scale: metres per
    unit. skin: (N, 3) vertices of the meshes that it deforms, in the rest pose; empty if there are none.
    """

    name: str
    names: tuple[str, ...]
    parents: np.ndarray
    heads: np.ndarray
    tails: np.ndarray
    bases: np.ndarray
    constrained: np.ndarray
    inherits: np.ndarray
    world: np.ndarray
    turn: np.ndarray
    scale: float
    skin: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))

    def index(self, bone: str) -> int:
        """Return the index of the bone of this name. Raise ValueError where there is none."""
        return self.names.index(bone)

    def above(self, bone: int) -> list[int]:
        """Return all bones above a bone, the nearest first."""
        result = []
        while (bone := int(self.parents[bone])) >= 0:
            result.append(bone)
        return result
