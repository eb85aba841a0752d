"""A progress bar in a terminal, and lines of it elsewhere."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, field

WIDTH = 30
"""Characters of the bar."""

LINES_BETWEEN = 10.0
"""Seconds between two lines where the output is no terminal."""


@dataclass
class ProgressBar:
    """How many of `total` lines of a jobs file are done, how many failed, and when the rest will be."""

    total: int
    begun: float = field(default_factory=time.monotonic)
    _shown: float = float("-inf")
    _longest: int = 0

    def show(self, done: int, failed: int, workers: int) -> None:
        """Print the present state; in a terminal over the last one."""
        now, terminal = time.monotonic(), sys.stdout.isatty()
        if not terminal and done < self.total and now - self._shown < LINES_BETWEEN:
            return
        self._shown = now
        text = self.text(done, failed, workers, now - self.begun)
        self._longest = max(self._longest, len(text))
        end = "\r" if terminal and done < self.total else "\n"
        print(text.ljust(self._longest if terminal else 0), end=end, flush=True)

    def text(self, done: int, failed: int, workers: int, seconds: float) -> str:
        """Return the bar after so many seconds."""
        share = done / self.total if self.total else 1.0
        filled = int(share * WIDTH)
        parts = [f"{done}/{self.total} lines", f"{failed} failed" if failed else "", f"{workers} workers"]
        if 0 < share < 1:
            parts.append(f"{_duration(seconds / share * (1 - share))} left")
        if share == 1:
            parts.append(_duration(seconds))
        return f"bake: [{'#' * filled}{'-' * (WIDTH - filled)}] {', '.join(filter(None, parts))}"


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
