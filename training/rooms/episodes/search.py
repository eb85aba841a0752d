"""Nearest-neighbour search of motion matching: one matrix product for all walkers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ....samp_addon.frames import wrap_angle
from .bank import POSE, Bank

STRIPES = 16  # candidates of each walker: the best frame of each part of the bank
PREFERENCES, PREFERENCE = 4, 0.12  # dimensions and scale of the walkers' preferences for clips
LOYAL, ENDING = 0.12, 1.0  # factors on the cost of continuing the current clip, on the route and near its end
LOOK = (6, 12, 20)  # frames at which a candidate's clearance is checked
ROOM, CROWDED = 0.25, 0.07  # wanted clearance (m), and deficit (m) with one unit of cost
Clearance = Callable[[np.ndarray], np.ndarray]


class Search:
    """The bank's features, indexed for queries."""

    def __init__(self, bank: Bank, seed: int = 0) -> None:
        self.bank = bank
        count = len(bank.rows) // STRIPES * STRIPES
        # Interleaved, so that every stripe contains frames of all clips.
        order = np.arange(count).reshape(-1, STRIPES).T.ravel()
        self.rows = bank.rows[order]
        features = bank.features[order]
        clip_vectors = (
            np.random.default_rng(seed).normal(size=(len(bank.names), PREFERENCES)).astype(np.float32)
        )
        self.table = np.concatenate(
            [-2 * features, (features**2).sum(1, keepdims=True), clip_vectors[bank.clip[self.rows]]], -1
        ).T.copy()

    def preferences(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Draw the clip preferences (count, PREFERENCES) of walkers."""
        return PREFERENCE * rng.normal(size=(count, PREFERENCES)).astype(np.float32)

    def frames(
        self, query: np.ndarray, preferences: np.ndarray, now: np.ndarray, flat: np.ndarray,
        clearance: Clearance | None, play: int, ending: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Return the bank frames (W,) to continue from.

        query: (W, 27) features. now: (W,) current bank frames, -1 for none. flat: (W, 3) x, z, yaw. clearance: function
        from positions (N, 2) to the distance from obstacles, metres. play: frames until the next search. ending: (W,)
        flags of walkers close to the end of their route.
        """
        bank, count = self.bank, len(query)
        one = np.ones((count, 1), np.float32)
        cost = (np.concatenate([query, one, preferences], -1) @ self.table).reshape(count, STRIPES, -1)
        best = cost.argmin(2)
        value = np.take_along_axis(cost, best[..., None], 2)[..., 0] + (query**2).sum(1, keepdims=True)
        frames = self.rows.reshape(STRIPES, -1)[np.arange(STRIPES), best]
        # Continuing the current clip is an additional candidate, at zero pose distance.
        on = (now >= 0) & (bank.ahead[now] > max(play, LOOK[-1]))
        row = np.clip(np.searchsorted(bank.rows, now), 0, len(bank.rows) - 1)
        on &= np.abs(bank.rows[row] - now) <= 2
        going = np.where(ending, ENDING, LOYAL) * ((bank.features[row, POSE:] - query[:, POSE:]) ** 2).sum(1)
        frames = np.concatenate([frames, np.where(on, now, frames[:, 0])[:, None]], 1)
        value = np.concatenate([value, np.where(on, going, np.inf)[:, None]], 1)
        if clearance is not None:
            value = value + self._crowding(frames, flat, clearance)
        return frames[np.arange(count), value.argmin(1)]

    def _crowding(self, frames: np.ndarray, flat: np.ndarray, clearance: Clearance) -> np.ndarray:
        """Return the cost (W, K) of missing clearance after candidates (W, K)."""
        bank = self.bank
        source = bank.flat[frames]
        turn = wrap_angle(flat[:, 2:] - source[..., 2])
        c, s = np.cos(turn), np.sin(turn)
        total = np.zeros(frames.shape)
        for ahead in LOOK:
            away = bank.flat[frames + ahead, :2] - source[..., :2]
            x = flat[:, :1] + away[..., 0] * c + away[..., 1] * s
            z = flat[:, 1:2] - away[..., 0] * s + away[..., 1] * c
            lack = np.maximum(ROOM - clearance(np.stack([x, z], -1)), 0.0)
            total += (lack / CROWDED) ** 2
        return total
