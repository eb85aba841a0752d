"""Which of many scored places are kept. Places are x and z (N, 2), yaws (N,) radians, lengths metres."""

from __future__ import annotations

import numpy as np

from ... import frames


def suppress(
    places: np.ndarray, yaws: np.ndarray, score: np.ndarray, action: str, limit: int, share: float = 1.0
) -> np.ndarray:
    """Return the indices of the best candidates, best first, by non-maximum suppression.

    Candidates close to a better one in both position and direction are dropped. share: scales both thresholds.
    """
    near, turn = (0.34, np.radians(50)) if action == "sit" else (0.45, np.radians(100))
    near, turn = share * near, share * turn
    left, chosen = score.copy(), []
    while len(chosen) < limit:
        best = int(np.argmax(left))
        if left[best] <= 0:
            break
        chosen.append(best)
        apart = np.hypot(*(places - places[best]).T)
        angle = np.abs(frames.wrap_angle(yaws - yaws[best]))
        # Much worse places are suppressed in a wider radius: the edge of a sofa between two seats with a back.
        reach = np.where(score < 0.7 * score[best], 1.4 * near, near)
        left[(apart < reach) & (angle < turn)] = 0
    return np.array(chosen, dtype=int)


def above_adjacent_seat(places: np.ndarray, height: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Flag the candidates (N,) above an adjacent seat that is about as good: wide backrests and armrests."""
    apart = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    drop = height[:, None] - height
    return ((apart < 0.9) & (drop > 0.1) & (drop < 0.5) & (score > 0.7 * score[:, None])).any(axis=1)
