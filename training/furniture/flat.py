"""Beds and tables."""

from __future__ import annotations

import numpy as np

from . import shapes
from .seating import Rng, legs, pedestal


def bed(rng: Rng) -> list[np.ndarray]:
    """Return a single or double bed or a low futon, head at -Z, with pillows and boards."""
    w, length = rng.choice([rng.uniform(0.85, 1.1), rng.uniform(1.3, 2.0)]), rng.uniform(1.95, 2.2)
    low = rng.random() < 0.15
    h = rng.uniform(0.15, 0.3) if low else rng.uniform(0.38, 0.66)
    thick = min(h * 0.8, rng.uniform(0.12, 0.25))
    x, z = w / 2, length / 2
    parts = [shapes.cushion((-x, h - thick, -z), (x, h, z), 0.1)]
    rim = rng.uniform(0.0, 0.08)
    base = rng.choice([0.0, rng.uniform(0.05, 0.2)]) if not low else 0.0
    base = min(base, h - thick - 0.02)
    parts.append(
        shapes.box(
            (-x - rim, max(base, 0.0), -z - rim), (x + rim, h - thick * rng.uniform(0.3, 1.0), z + rim), 4
        )
    )
    if base > 0.02:
        parts += legs(rng, w, length, base, 0.03)
    if rng.random() < 0.75:
        parts.append(
            shapes.box((-x - rim, 0, -z - rim - 0.06), (x + rim, h + rng.uniform(0.15, 0.6), -z - rim), 4)
        )
        if rng.random() < 0.35:
            parts.append(
                shapes.box((-x - rim, 0, z + rim), (x + rim, h + rng.uniform(0.0, 0.3), z + rim + 0.05), 4)
            )
    if rng.random() < 0.7:
        parts += _pillows(rng, w, h, -z)
    return parts


def _pillows(rng: Rng, width: float, top: float, head: float) -> list[np.ndarray]:
    count = 1 if width < 1.25 else 2
    thick, deep = rng.uniform(0.06, 0.13), rng.uniform(0.35, 0.5)
    edges = np.linspace(-width / 2 + 0.06, width / 2 - 0.06, count + 1)
    return [
        shapes.cushion((a + 0.03, top - 0.02, head + 0.05), (b - 0.03, top + thick, head + 0.05 + deep), 0.5)
        for a, b in zip(edges[:-1], edges[1:], strict=True)
    ]


def table(rng: Rng) -> list[np.ndarray]:
    """Return a dining, coffee or side table or a desk: square or round, on legs, a column or two panels."""
    coffee = rng.random() < 0.35
    h = rng.uniform(0.34, 0.52) if coffee else rng.uniform(0.70, 0.78)
    thick = rng.uniform(0.018, 0.05)
    if rng.random() < 0.25:
        r = rng.uniform(0.3, 0.6)
        base = (
            pedestal(rng, r * 0.6, h - thick)
            if rng.random() < 0.6
            else legs(rng, r * 1.3, r * 1.3, h - thick)
        )
        return [shapes.disc(r, h - thick, h), *base]
    w, d = rng.uniform(0.8, 2.0), rng.uniform(0.45, 1.0)
    d = min(d, w)
    parts = [shapes.box((-w / 2, h - thick, -d / 2), (w / 2, h, d / 2), 4)]
    if rng.random() < 0.25:
        for s in (-1, 1):
            x = s * (w / 2 - 0.06)
            parts.append(shapes.box((x - 0.02, 0, -d / 2 + 0.03), (x + 0.02, h - thick, d / 2 - 0.03)))
    else:
        parts += legs(rng, w - 0.06, d - 0.06, h - thick, rng.uniform(0.02, 0.04))
        if rng.random() < 0.5:
            parts.append(
                shapes.box(
                    (-w / 2 + 0.06, h - thick - 0.08, -d / 2 + 0.06), (w / 2 - 0.06, h - thick, d / 2 - 0.06)
                )
            )
    return parts
