"""Standing poses in which takes may begin. Network frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np


def usable(rotations: np.ndarray) -> np.ndarray:
    """Return flags (K,) of the standing poses (K, 22, 4) to choose from: those whose hands hang, else all.

    A person who waits with raised hands seems to hold something.
    """
    hanging = hands_hang(rotations)
    return hanging if hanging.any() else ~hanging


def hands_hang(rotations: np.ndarray) -> np.ndarray:
    """Return flags (K,) of standing poses (K, 22, 4) with both wrists below the pelvis joint."""
    import numpy as np

    from .. import skeleton

    joints, _ = skeleton.forward_kinematics(
        np.zeros((len(rotations), 3)), rotations, skeleton.default_rest_joints()
    )
    wrists = [skeleton.INDEX[f"{side}_wrist"] for side in ("left", "right")]
    return (joints[:, wrists, 1] < 0).all(1)
