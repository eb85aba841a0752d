"""Procedural small objects for floors and tables, on y = 0, centred over the origin, metres."""

from __future__ import annotations

import numpy as np

from ...furniture import shapes
from ..classes import Part

Rng = np.random.Generator


def plant(rng: Rng) -> list[Part]:
    """Return a pot with leaves."""
    r, h = rng.uniform(0.1, 0.2), rng.uniform(0.18, 0.4)
    pot = shapes.lathe([[1e-6, 0], [r * 0.75, 0], [r, h], [r * 0.85, h], [1e-6, h - 0.03]])
    leaves = []
    for _ in range(int(rng.integers(8, 22))):
        yaw, rise, long = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 1.3), rng.uniform(0.25, 0.7)
        way = np.array([np.sin(yaw) * np.cos(rise), np.sin(rise), np.cos(yaw) * np.cos(rise)])
        side = np.array([np.cos(yaw), 0, -np.sin(yaw)]) * rng.uniform(0.03, 0.08)
        base, tip = np.array([0, h - 0.02, 0]), np.array([0, h, 0]) + way * long
        middle = (base + tip) / 2 + [0, 0.04, 0]
        leaves.append(np.array([[base, middle - side, middle + side], [middle - side, tip, middle + side]]))
    return [Part("clutter", pot), Part("clutter", np.concatenate(leaves))]


def floor_lamp(rng: Rng) -> list[Part]:
    """Return a standard lamp with a shade."""
    h, r = rng.uniform(1.3, 1.75), rng.uniform(0.14, 0.24)
    stand = [shapes.disc(0.15, 0, 0.025), shapes.tube([(0, 0.02, 0), (0, h, 0)], 0.012)]
    shade = shapes.lathe(
        [[r * 0.7, h + 0.12], [r, h - 0.18], [r - 0.006, h - 0.18], [r * 0.7 - 0.006, h + 0.12]]
    )
    return [Part("clutter", shapes.join(stand)), Part("clutter", shade)]


def crate(rng: Rng) -> list[Part]:
    """Return a box or a basket."""
    x, h, z = rng.uniform(0.12, 0.28), rng.uniform(0.15, 0.5), rng.uniform(0.12, 0.25)
    return [Part("clutter", shapes.box((-x, 0, -z), (x, h, z)))]


def bin_(rng: Rng) -> list[Part]:
    """Return a waste-paper bin."""
    r, h = rng.uniform(0.1, 0.16), rng.uniform(0.25, 0.42)
    return [
        Part(
            "clutter",
            shapes.lathe([[1e-6, 0], [r * 0.8, 0], [r, h], [r - 0.008, h], [r * 0.78, 0.02], [1e-6, 0.02]]),
        )
    ]


def bag(rng: Rng) -> list[Part]:
    """Return a bag on the floor."""
    x, h, z = rng.uniform(0.13, 0.22), rng.uniform(0.25, 0.42), rng.uniform(0.07, 0.13)
    body = shapes.cushion((-x, 0, -z), (x, h, z), 0.45)
    return [
        Part(
            "clutter", shapes.join([body, shapes.tube([(-0.06, h, 0), (0, h + 0.1, 0), (0.06, h, 0)], 0.008)])
        )
    ]


ON_FLOOR = (plant, plant, floor_lamp, crate, bin_, bag)


def cup(rng: Rng) -> list[Part]:
    """Return a cup or a glass."""
    r, h = rng.uniform(0.03, 0.045), rng.uniform(0.07, 0.14)
    return [
        Part("clutter", shapes.lathe([[1e-6, 0], [r * 0.8, 0], [r, h], [r - 0.004, h], [1e-6, 0.01]], 12))
    ]


def bowl(rng: Rng) -> list[Part]:
    """Return a bowl or a plate."""
    r, h = rng.uniform(0.09, 0.16), rng.uniform(0.02, 0.09)
    return [Part("clutter", shapes.lathe([[1e-6, 0], [r * 0.5, 0], [r, h], [r - 0.008, h], [1e-6, 0.012]]))]


def books(rng: Rng) -> list[Part]:
    """Return a pile of books or magazines."""
    parts, at = [], 0.0
    for _ in range(int(rng.integers(1, 5))):
        x, z, t = rng.uniform(0.09, 0.14), rng.uniform(0.07, 0.1), rng.uniform(0.008, 0.035)
        parts.append(shapes.turned(shapes.box((-x, at, -z), (x, at + t, z), 1), rng.uniform(-0.3, 0.3)))
        at += t
    return [Part("clutter", np.concatenate(parts))]


def vase(rng: Rng) -> list[Part]:
    """Return a vase with stalks."""
    r, h = rng.uniform(0.04, 0.08), rng.uniform(0.15, 0.3)
    body = shapes.lathe([[1e-6, 0], [r * 0.7, 0], [r, h * 0.4], [r * 0.5, h * 0.85], [r * 0.6, h]])
    stalks = [
        shapes.tube(
            [(0, h * 0.6, 0), (rng.uniform(-0.1, 0.1), h + rng.uniform(0.1, 0.3), rng.uniform(-0.1, 0.1))],
            0.006,
            5,
        )
        for _ in range(4)
    ]
    return [Part("clutter", shapes.join([body, *stalks]))]


def laptop(rng: Rng) -> list[Part]:
    """Return an open laptop, its keys towards +Z."""
    keys = shapes.box((-0.16, 0, -0.11), (0.16, 0.018, 0.11))
    lid = shapes.tilted(
        shapes.box((-0.16, 0.01, -0.115), (0.16, 0.23, -0.107)), rng.uniform(0.1, 0.4), (0, 0.01, -0.11)
    )
    return [Part("clutter", keys), Part("clutter", lid)]


def monitor(rng: Rng) -> list[Part]:
    """Return a screen on a foot with a keyboard, its face towards +Z."""
    x, h = rng.uniform(0.24, 0.34), rng.uniform(0.28, 0.36)
    foot = [shapes.disc(0.1, 0, 0.012), shapes.box((-0.02, 0, -0.02), (0.02, 0.2, 0.0))]
    face = shapes.box((-x, 0.1, 0.0), (x, 0.1 + h, 0.03))
    return [
        Part("clutter", shapes.join([*foot, face])),
        Part("clutter", shapes.box((-0.2, 0, 0.15), (0.2, 0.02, 0.28))),
    ]


def table_lamp(rng: Rng) -> list[Part]:
    """Return a small lamp."""
    h, r = rng.uniform(0.25, 0.45), rng.uniform(0.08, 0.14)
    stand = [shapes.disc(0.07, 0, 0.02), shapes.tube([(0, 0.02, 0), (0, h, 0)], 0.01)]
    return [
        Part("clutter", shapes.join(stand)),
        Part("clutter", shapes.lathe([[r * 0.6, h + 0.08], [r, h - 0.1]])),
    ]


ON_TABLE = {
    "living": (cup, bowl, books, vase, laptop),
    "dining": (cup, cup, bowl, bowl, vase), "kitchen": (cup, bowl, vase, books),
    "office": (monitor, laptop, cup, books, table_lamp), "bedroom": (table_lamp, books, cup, vase),
    "waiting": (books, vase, books), "cafe": (cup, cup, bowl, vase),
}  # fmt: skip
"""Builders of objects on tables, by the kind of room."""
