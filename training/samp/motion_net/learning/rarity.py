"""Weights of the sequences of a training set by the rarity of the postures that they lead to."""

from __future__ import annotations

import numpy as np

from .....samp_addon.vocabulary import POSTURE_NAMES, POSTURES

WANTED_SHARE = 0.2  # share of the rests of its action that a rare posture is raised to
LARGEST = 8.0  # largest weight: beyond it, few captures would be learnt by heart


def weights(postures: np.ndarray, kinds: np.ndarray) -> np.ndarray:
    """Return weights (S,) of sequences with postures (S, 9), in the order of POSTURE_NAMES, and kinds (S,).

    A sequence counts as often as its rarest posture needs to reach WANTED_SHARE of its action, at most LARGEST times.
    """
    shown = postures >= 0.5
    out = np.ones(len(postures), np.float32)
    for action, names in POSTURES.items():
        rests = (kinds == action) & shown.any(1)
        if not rests.any():
            continue
        columns = [POSTURE_NAMES.index(name) for name in names]
        share = shown[rests][:, columns].mean(0)
        needed = np.clip(WANTED_SHARE / np.maximum(share, 1e-9), 1.0, LARGEST)
        out[rests] = np.where(shown[rests][:, columns], needed, 1.0).max(1)
    return out
