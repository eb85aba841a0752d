"""The record of a rollout: all frames of all takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .... import skeleton
from .tracking import FPS, Observation

if TYPE_CHECKING:
    from .rollout import Frame

LOOK_BACK = 5  # frames over which the speed of a pelvis is measured
CHEST = skeleton.INDEX["spine3"]
RECORDED = ("pelvis", "matrices", "contacts", "actions", "roots", "travelled")


class Record:
    """Recorded values of B takes, frame by frame: for each name of RECORDED an array (T, B, ...).

    length: frames recorded so far. lengths: (B,) frames of each take.
    """

    def __init__(self, takes: int) -> None:
        self.length, self.lengths = 0, np.zeros(takes, int)
        self.values: dict[str, np.ndarray] = {}

    def add(self, frame: Frame, travelled: np.ndarray, going: np.ndarray) -> None:
        """Append a frame of the takes ``going`` (K,), and the distances travelled before it (K,)."""
        for name in RECORDED:
            new = travelled if name == "travelled" else getattr(frame, name).numpy()
            kept = self.values.get(name, np.empty((0, len(self.lengths), *new.shape[1:]), np.float32))
            if self.length == len(kept):
                kept = np.concatenate([kept, np.zeros((max(len(kept), 256), *kept.shape[1:]), np.float32)])
            kept[self.length, going] = new
            self.values[name] = kept
        self.length += 1
        self.lengths[going] = self.length

    def newest(self, name: str, going: np.ndarray, back: int = 0) -> np.ndarray:
        """Return the values (K, ...) of some takes (K,), ``back`` frames ago or in the first frame."""
        return self.values[name][max(0, self.length - 1 - back), going]

    def observe(self, going: np.ndarray) -> Observation:
        """Return the observation of the newest frame of some takes (K,)."""
        pelvis, before = self.newest("pelvis", going), self.newest("pelvis", going, LOOK_BACK)
        span = max(min(self.length - 1, LOOK_BACK), 1) / FPS
        return Observation(
            roots=self.newest("roots", going)[:, :2],
            pelvis=pelvis,
            speed=np.linalg.norm(pelvis - before, axis=-1) / span,
            vertical_speed=np.abs(pelvis[:, 1] - before[:, 1]) / span,
            weights=self.newest("actions", going),
            upright=self.newest("matrices", going)[:, CHEST, 1, 1],
        )

    def of(self, take: int) -> dict[str, np.ndarray]:
        """Return all values of one take by name, (T, ...) each."""
        return {
            name: kept[: self.lengths[take], take].astype(np.float64) for name, kept in self.values.items()
        }
