"""The hierarchy of an unknown rig's bones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


class Tree:
    """The hierarchy of the bones. depth: (B,) number of bones above each."""

    def __init__(self, parents: Sequence[int]) -> None:
        self.parents = [int(parent) for parent in parents]
        self.depth = [len(self.above(bone)) for bone in range(len(self.parents))]

    def main_path(self, bone: int, heads: np.ndarray, within: np.ndarray | None = None) -> list[int]:
        """Return a bone and those that lead on from it, up to where three or more branch off, as fingers do."""
        path = [bone]
        while True:
            below = [b for b, parent in enumerate(self.parents) if parent == path[-1]]
            below = below if within is None else [b for b in below if within[b]]
            if not 1 <= len(below) <= 2:
                return path
            # Of two, the one that leads on; twist bones end.
            path.append(
                max(below, key=lambda b: (self.parents.count(b) > 0, np.linalg.norm(heads[b] - heads[bone])))
            )

    def above(self, bone: int) -> list[int]:
        """Return all bones above a bone, the nearest first."""
        result = []
        while (bone := self.parents[bone]) >= 0:
            result.append(bone)
        return result

    def between(self, upper: int, lower: int) -> list[int]:
        """Return the bones between two, from above; none where ``lower`` is not below ``upper``."""
        path = self.above(lower)
        return path[: path.index(upper)][::-1] if upper in path else []


def spine_joints(spine: Sequence[int]) -> tuple[tuple[str, ...], list[int]]:
    """Return the joints of a spine of some bones, and the bone of each: at most both ends and the middle."""
    joints = {0: (), 1: ("spine3",), 2: ("spine1", "spine3")}.get(len(spine), ("spine1", "spine2", "spine3"))
    return joints, list(spine) if len(spine) <= 2 else [spine[0], spine[len(spine) // 2], spine[-1]]
