"""Two motions in a row: the offset at the join fades out. Network frame, metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .. import rotation
from ..body.hands import complete
from ..easing import smoothstep
from ..motion import Motion

FADE = 12
"""Frames in which the offset at a joint between two steps fades out."""


def append(first: Motion, second: Motion) -> Motion:
    """Return both motions in a row; the offset of the second at the join fades out."""
    if first.rotations.shape[1] != second.rotations.shape[1]:  # a method with hands after one without
        first, second = (replace(m, rotations=complete(m.rotations)) for m in (first, second))
    ahead = 2 * first.root[-1] - first.root[-2] if len(first) > 1 else first.root[-1]
    root, turned = faded(second, ahead, first.rotations[-1])
    rotations = np.concatenate([first.rotations, turned])
    both = lambda a, b: None if a is None or b is None else np.concatenate([a, b])
    begun = second.interaction_start
    return replace(
        first,
        root=np.concatenate([first.root, root]),
        rotations=rotation.continuous(rotations),
        contacts=both(first.contacts, second.contacts),
        actions=both(first.actions, second.actions),
        interaction_start=None if begun is None else begun + len(first),
    )


def faded(motion: Motion, root: np.ndarray, rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return root (T, 3) and rotations (T, J, 4) of a motion that begins with this root (3,) and pose (J, 4)."""
    weight = smoothstep(1 - np.arange(len(motion)) / FADE)
    moved = motion.root + weight[:, None] * (root - motion.root[0])
    offset = rotation.multiply(rotations, rotation.conjugate(motion.rotations[0]))
    still = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), motion.rotations.shape)
    fading = rotation.slerp(still, np.broadcast_to(offset, motion.rotations.shape), weight[:, None])
    return moved, rotation.multiply(fading, motion.rotations)
