"""Measure how much of a motion is as captured, by the rotations of legs and trunk."""

from __future__ import annotations

import numpy as np

from .bank import Bank
from .scene import PlacedUse, Scene

UNKNOWN = 255
LEGS_TRUNK = [1, 2, 3, 4, 5, 6, 7, 8, 9]  # hips, spine, knees, ankles
ALIKE = 10  # degrees


def deviation(bank: Bank, rotations: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Return the deviation (T,), uint8 degrees, of legs and trunk from the captured frame, UNKNOWN without one.

    rotations: (T, 22, 4). source: (T,) bank frames or -1. The joint with the largest deviation counts.
    """
    captured = bank.rotations[np.maximum(source, 0)]
    dots = np.abs((rotations[:, LEGS_TRUNK] * captured[:, LEGS_TRUNK]).sum(-1))
    angle = np.degrees(2 * np.arccos(np.clip(dots, 0, 1))).max(1)
    return np.where(source >= 0, np.minimum(np.ceil(angle), UNKNOWN - 1), UNKNOWN).astype(np.uint8)


def share(bank: Bank, scene: Scene, placed: PlacedUse) -> float:
    """Return the share of a use's frames that are within ALIKE degrees of a captured frame; cached in the scene."""
    key = id(placed)
    if key not in scene.captured:
        turned = deviation(bank, placed.rotations, placed.use.source)
        scene.captured[key] = float((turned <= ALIKE).mean())
    return scene.captured[key]
