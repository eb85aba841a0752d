"""Procedural storage and boards: cupboards, shelves, counters, boards; front +Z, on y = 0, back at z = 0, metres."""

from __future__ import annotations

import numpy as np

from ...furniture import shapes
from ..classes import Part

Rng = np.random.Generator


def _fronts(
    rng: Rng, width: float, low: float, high: float, z: float, columns: int, rows: int
) -> list[np.ndarray]:
    """Return doors or drawers on a front, with narrow gaps and handles."""
    xs, ys = np.linspace(-width / 2, width / 2, columns + 1), np.linspace(low, high, rows + 1)
    knob, parts = rng.random() < 0.5, []
    for a, b in zip(xs[:-1], xs[1:], strict=True):
        for c, d in zip(ys[:-1], ys[1:], strict=True):
            parts.append(shapes.box((a + 0.004, c + 0.004, z), (b - 0.004, d - 0.004, z + 0.018)))
            x, y = (a + b) / 2, (c + d) / 2
            reach = 0.012 if knob else min(0.3 * (b - a), 0.12)
            parts.append(shapes.box((x - reach, y - 0.008, z + 0.018), (x + reach, y + 0.008, z + 0.04)))
    return parts


def cabinet(rng: Rng, width: float, height: float, depth: float, columns: int, rows: int) -> list[Part]:
    """Return a closed cupboard on a plinth or on feet."""
    foot = rng.choice([0.0, rng.uniform(0.05, 0.18)]) if height < 1.2 else rng.uniform(0.0, 0.08)
    x = width / 2
    parts = [shapes.box((-x, foot, 0), (x, height, depth - 0.02), 3)]
    parts += _fronts(rng, width, foot + 0.01, height - 0.02, depth - 0.02, columns, rows)
    if foot:
        parts += [
            shapes.box((s * (x - 0.05) - 0.02, 0, z), (s * (x - 0.05) + 0.02, foot, z + 0.04))
            for s in (-1, 1)
            for z in (0.02, depth - 0.08)
        ]
    return [Part("cupboard", shapes.join(parts))]


def wardrobe(rng: Rng) -> list[Part]:
    """Return a tall cupboard for clothes, 1 to 2.4 m wide."""
    doors = int(rng.integers(2, 5))
    return cabinet(
        rng, doors * rng.uniform(0.45, 0.6), rng.uniform(1.85, 2.25), rng.uniform(0.52, 0.62), doors, 1
    )


def sideboard(rng: Rng) -> list[Part]:
    """Return a low, wide cupboard."""
    columns = int(rng.integers(2, 5))
    width = columns * rng.uniform(0.4, 0.55)
    return cabinet(
        rng, width, rng.uniform(0.45, 0.95), rng.uniform(0.35, 0.48), columns, int(rng.integers(1, 3))
    )


def drawers(rng: Rng) -> list[Part]:
    """Return a chest of drawers."""
    return cabinet(
        rng, rng.uniform(0.6, 1.1), rng.uniform(0.75, 1.2), rng.uniform(0.4, 0.5), 1, int(rng.integers(3, 6))
    )


def nightstand(rng: Rng) -> list[Part]:
    """Return a small cupboard beside a bed."""
    size = rng.uniform(0.38, 0.5)
    return cabinet(rng, size, rng.uniform(0.4, 0.6), rng.uniform(0.34, 0.42), 1, int(rng.integers(1, 3)))


def fridge(rng: Rng) -> list[Part]:
    """Return a fridge with one door or two stacked ones."""
    return cabinet(rng, rng.uniform(0.56, 0.7), rng.uniform(1.4, 1.95), 0.64, 1, int(rng.integers(1, 3)))


def counter(rng: Rng, width: float, wall_cupboards: bool) -> list[Part]:
    """Return a run of kitchen cupboards with a worktop, a basin and a hob, and optional wall cupboards."""
    depth, height, columns = 0.6, rng.uniform(0.86, 0.93), max(int(round(width / 0.55)), 1)
    x = width / 2
    parts = [shapes.box((-x, 0.1, 0), (x, height - 0.04, depth - 0.03), 3)]
    parts += [shapes.box((-x, 0.0, 0.05), (x, 0.1, depth - 0.09))]
    parts += _fronts(rng, width, 0.11, height - 0.05, depth - 0.03, columns, int(rng.integers(1, 4)))
    top = [shapes.box((-x - 0.01, height - 0.04, 0), (x + 0.01, height, depth), 3)]
    things = []
    if width > 1.3:
        at = rng.uniform(-x + 0.35, x - 0.35)
        things.append(shapes.box((at - 0.25, height, 0.1), (at + 0.25, height + 0.012, depth - 0.1)))
        tap = [
            (at, height, 0.08),
            (at, height + 0.25, 0.08),
            (at, height + 0.27, 0.2),
            (at, height + 0.2, 0.22),
        ]
        things.append(shapes.tube(tap, 0.012))
    if width > 2.0:
        at = rng.uniform(-x + 0.35, x - 0.35)
        things += [
            shapes.disc(0.09, height + 0.001, height + 0.014) + [at + a, 0, 0.3 + b]
            for a in (-0.13, 0.13)
            for b in (-0.12, 0.12)
        ]
    over = []
    if wall_cupboards:
        low, high, front = rng.uniform(1.38, 1.5), rng.uniform(2.0, 2.2), 0.34
        over = [
            shapes.box((-x, low, 0), (x, high, front), 2),
            *_fronts(rng, width, low, high, front, columns, 1),
        ]
    out = [Part("cupboard", shapes.join(parts + over)), Part("cupboard", shapes.join(top))]
    return [*out, Part("clutter", shapes.join(things))] if things else out


def desk_counter(rng: Rng, width: float) -> list[Part]:
    """Return a reception or bar counter, closed to the front."""
    x, height = width / 2, rng.uniform(0.98, 1.12)
    body = [shapes.box((-x, 0, 0.05), (x, height - 0.04, 0.5), 4)]
    body += [
        shapes.box((k - 0.01, 0.05, 0.5), (k + 0.01, height - 0.08, 0.515))
        for k in np.arange(-x + 0.2, x, 0.4)
    ]
    return [
        Part("cupboard", shapes.join(body)),
        Part("table", shapes.box((-x - 0.05, height - 0.04, 0), (x + 0.05, height, 0.62), 3)),
    ]


def bookshelf(rng: Rng) -> list[Part]:
    """Return an open shelf with books."""
    width, depth = rng.uniform(0.6, 1.6), rng.uniform(0.25, 0.36)
    height, rows = rng.uniform(0.8, 2.15), 0
    rows = max(int(height / rng.uniform(0.3, 0.42)), 2)
    columns = max(int(round(width / 0.8)), 1)
    x, t = width / 2, 0.02
    levels = np.linspace(0.04, height - t, rows + 1)
    parts = [shapes.box((-x, y, 0), (x, y + t, depth)) for y in levels]
    for edge in np.linspace(-x, x - t, columns + 1):
        parts.append(shapes.box((edge, 0, 0), (edge + t, height, depth)))
    if rng.random() < 0.7:
        parts.append(shapes.box((-x, 0, 0), (x, height, 0.012)))
    books = []
    for low, high in zip(levels[:-1], levels[1:], strict=True):
        for column in range(columns):
            a, b = -x + t + column * width / columns, -x + (column + 1) * width / columns - t
            books += _row_of_books(rng, a, b, low + t, high - low - t, depth)
    out = [Part("shelf", shapes.join(parts))]
    return [*out, *[Part("clutter", shapes.join(books[k::3])) for k in range(min(3, len(books)))]]


def _row_of_books(rng: Rng, a: float, b: float, low: float, room: float, depth: float) -> list[np.ndarray]:
    if rng.random() < 0.2 or room < 0.12:
        return []
    books, at, end = [], a + 0.01, a + (b - a) * rng.uniform(0.3, 1.0)
    while at < end - 0.04:
        thick, high = rng.uniform(0.015, 0.05), min(rng.uniform(0.16, 0.3), room - 0.02)
        deep = min(rng.uniform(0.12, 0.2), depth - 0.03)
        books.append(shapes.box((at, low, 0.03), (at + thick, low + high, 0.03 + deep), 1))
        at += thick + 0.002
    return books


def board(rng: Rng, kind: str) -> list[Part]:
    """Return a whiteboard, picture or screen to hang on a wall, back at z = 0, lower edge at y = 0."""
    sizes = {
        "whiteboard": ((1.0, 2.0), (0.8, 1.2)),
        "picture": ((0.3, 1.2), (0.3, 0.9)),
        "screen": ((0.9, 1.5), (0.55, 0.85)),
    }
    (a, b), (c, d) = sizes[kind]
    x, height = rng.uniform(a, b) / 2, rng.uniform(c, d)
    rim = 0.02 if kind != "picture" else rng.uniform(0.01, 0.05)
    frame = [shapes.box((-x, 0, 0), (x, height, 0.025))]
    face = [shapes.box((-x + rim, rim, 0.025), (x - rim, height - rim, 0.03))]
    if kind == "whiteboard":
        frame.append(shapes.box((-x * 0.6, -0.02, 0.02), (x * 0.6, 0.0, 0.08)))
    return [Part("board", shapes.join(frame)), Part("board", shapes.join(face))]
