"""Count how much of a composed clip is captured and how much is fitted, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...samp_addon import skeleton
from ..mocap.clip_files import Clip

SAME = np.radians(3.0)  # largest change of a joint's local rotation that counts as captured
LEGS = [skeleton.INDEX[f"{side}_{name}"] for side in ("left", "right") for name in ("hip", "knee", "ankle")]
TRUNK = [skeleton.INDEX[f"spine{k}"] for k in (1, 2, 3)]
ARMS = [skeleton.INDEX[f"{side}_{name}"] for side in ("left", "right") for name in ("shoulder", "elbow")]


@dataclass(frozen=True)
class Owed:
    """Number of frames of a clip, and of those with legs, trunk, both, and arms rotated as captured."""

    frames: int
    legs: int
    trunk: int
    both: int
    arms: int


def owed(captured: Clip, made: Clip) -> Owed:
    """Count the frames of a fitted clip whose joints are as captured within SAME, apart from root and heading."""
    dot = np.abs((captured.rotations * made.rotations).sum(-1)).clip(0, 1)
    same = 2 * np.arccos(dot) < SAME
    legs, trunk, arms = (same[:, part].all(1) for part in (LEGS, TRUNK, ARMS))
    return Owed(len(made), int(legs.sum()), int(trunk.sum()), int((legs & trunk).sum()), int(arms.sum()))


def total(counts: list[Owed]) -> dict[str, float]:
    """Return the shares of all frames."""
    frames = max(sum(c.frames for c in counts), 1)
    return {
        name: sum(getattr(c, name) for c in counts) / frames for name in ("legs", "trunk", "both", "arms")
    }
