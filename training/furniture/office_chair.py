"""Office chairs on five castors."""

from __future__ import annotations

import numpy as np

from . import shapes
from .seating import Rng, armrests


def five_star(rng: Rng, top: float) -> list[np.ndarray]:
    """Return an office chair's base: five spokes on castors and a gas column."""
    reach = rng.uniform(0.26, 0.34)
    parts = [shapes.disc(0.03, 0.08, top)]
    for k in range(5):
        way = np.array([np.sin(2 * np.pi * k / 5), 0, np.cos(2 * np.pi * k / 5)])
        parts.append(shapes.tube([way * 0.02 + [0, 0.11, 0], way * reach + [0, 0.07, 0]], 0.018))
        parts.append(
            shapes.cushion(way * reach - 0.028 + [0, 0.028, 0], way * reach + 0.028 + [0, 0.028, 0], 0.9)
        )
    return parts


def office_chair(rng: Rng) -> list[np.ndarray]:
    """Return a swivel chair on five castors, mostly with armrests."""
    w, d, h = rng.uniform(0.44, 0.52), rng.uniform(0.42, 0.50), rng.uniform(0.42, 0.52)
    parts = [shapes.cushion((-w / 2, h - 0.08, -d / 2), (w / 2, h, d / 2), 0.35), *five_star(rng, h - 0.05)]
    lift = rng.uniform(0.05, 0.15)
    back = shapes.curved_panel(
        w * 0.9, rng.uniform(0.4, 0.65), 0.06, rng.uniform(0.03, 0.1), (0, h + lift, -d / 2 - 0.04)
    )
    spine = shapes.box((-0.03, h - 0.06, -d / 2 - 0.05), (0.03, h + lift + 0.2, -d / 2 - 0.03))
    parts += [shapes.tilted(part, rng.uniform(0.05, 0.2), (0, h, -d / 2)) for part in (back, spine)]
    return parts + (armrests(rng, w + 0.04, d, h) if rng.random() < 0.6 else [])
