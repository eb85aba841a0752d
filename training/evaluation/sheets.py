"""Contact sheets of random takes, from two sides, for visual checks."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...samp_addon.vocabulary import SEATED
from ..look import cut, look
from .takes import Results

BEFORE = 2.5  # seconds shown before the body sits or lies down
TILES = 12


def draw(action: str, results: Results, folder: Path, count: int, seed: int = 0) -> list[Path]:
    """Draw sheets of up to ``count`` random takes, of sits and lies from BEFORE on; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    chosen = np.sort(np.random.default_rng(seed).permutation(len(results.takes))[:count])
    paths = []
    for k in chosen:
        motion = results.takes[k].motion
        start = (motion.interaction_start or 0) / motion.fps - BEFORE
        paths.append(
            look(
                cut(motion, max(start, 0.0), None),
                folder / f"{action}_{k:03d}.png",
                triangles=results.furniture[k],
                count=TILES,
                follow=action not in SEATED,
                size=(280, 240),
            )
        )
    return paths
