"""Table cells: measures with their uncertainty, the paper's values and the wanted ones."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

PAPER = {
    ("sit", "position_error_cm"): 6.09, ("sit", "rotation_error_deg"): 3.55, ("sit", "execution_time_s"): 12.53,
    ("lie", "position_error_cm"): 5.76, ("lie", "rotation_error_deg"): 6.45, ("lie", "execution_time_s"): 17.06,
    ("sit", "penetration_5cm_percent"): 3.8, ("sit", "FD"): 104.68, ("lie", "FD"): 17.30, ("walk", "FD"): 111.09,
    ("run", "FD"): 141.11,
}  # fmt: skip
"""Values of SAMP, tables 2 to 5; its penetration is the share of frames with any penetration."""

WANTED = {
    ("sit", "success"): ">= 97 %", ("lie", "success"): ">= 95 %", ("sit", "position_error_cm"): "<= 4",
    ("sit", "rotation_error_deg"): "<= 3", ("lie", "position_error_cm"): "<= 5",
    ("lie", "rotation_error_deg"): "<= 5", ("sit", "penetration_5cm_percent"): "<= 3",
    ("lie", "penetration_5cm_percent"): "<= 3",
}  # fmt: skip
ANY = {
    "stance_slide_cm_s": "<= 3", "foot_slide_cm_s": "<= real", "jerk_m_s3": "<= 1.3 x real", "APD": ">= 0.9 x real",
    "execution_ratio": "<= 1.10", "air_squat_s": "<= 1.0", "unsupported_s": "<= 0.25", "seated_speed_m_s": "<= 0.6",
    "hanging_feet_cm": "<= 3",
}  # fmt: skip


RESAMPLES = 4000


@dataclass(frozen=True)
class Estimate:
    """A mean with the half-width of its 95 % interval, from ``count`` values."""

    mean: float
    half: float
    count: int

    @classmethod
    def of(cls, values: Sequence[float], clusters: Sequence[str] | None = None) -> Estimate:
        """Return the mean and its interval, whose width is NaN for a single value. Raise ValueError for none.

        clusters: the piece or room of each value, over which the interval is bootstrapped, since takes on one piece are
        not independent. Without them, the interval is Student's.
        """
        count = len(values)
        if not count:
            raise ValueError("a mean needs at least one value")
        mean = statistics.fmean(values)
        if clusters is not None:
            return cls(mean, _bootstrapped(values, clusters), count)
        if count < 2:
            return cls(mean, math.nan, count)
        half = float(stats.t.ppf(0.975, count - 1)) * statistics.stdev(values) / math.sqrt(count)
        return cls(mean, half, count)

    def __str__(self) -> str:
        return f"{self.mean:.2f}" if math.isnan(self.half) else f"{self.mean:.2f} ± {self.half:.2f}"


def _bootstrapped(values: Sequence[float], clusters: Sequence[str]) -> float:
    """Return half the width of the mean's 95 % interval by resampling clusters; NaN for fewer than two."""
    names, owner = np.unique(list(clusters), return_inverse=True)
    if len(names) < 2:
        return math.nan
    sums, sizes = np.bincount(owner, np.asarray(values, float)), np.bincount(owner)
    drawn = np.random.default_rng(0).integers(len(names), size=(RESAMPLES, len(names)))
    means = sums[drawn].sum(1) / sizes[drawn].sum(1)
    low, high = np.percentile(means, [2.5, 97.5])
    return float(high - low) / 2


def share(won: int, asked: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval (0 to 1) of a share of successes. Raise ValueError for an invalid share."""
    if asked < 1 or not 0 <= won <= asked:
        raise ValueError(f"{won} of {asked} is not a valid share")
    interval = stats.binomtest(won, asked).proportion_ci(0.95, "wilson")
    return float(interval.low), float(interval.high)


def row(action: str, key: str, name: str, measured: str, real: float | None = None) -> str:
    """Return one line of Markdown: measure, measured, real motion, paper, wanted."""
    paper = PAPER.get((action, key))
    wanted = WANTED.get((action, key), ANY.get(key, ""))
    cells = [
        name,
        measured,
        "" if real is None else f"{real:.2f}",
        "" if paper is None else f"{paper:g}",
        wanted,
    ]
    return "| " + " | ".join(cells) + " |"


HEADER = "| measure | measured (95 %) | real motion | paper | wanted |\n|---|---|---|---|---|"
