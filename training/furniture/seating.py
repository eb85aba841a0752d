"""Chairs, stools, benches and sofas: one function for each category, with dimensions drawn from ranges."""

from __future__ import annotations

import numpy as np

from . import shapes

Rng = np.random.Generator


def legs(rng: Rng, width: float, depth: float, top: float, thick: float | None = None) -> list[np.ndarray]:
    """Return four legs, straight or splayed, round or square, under a plate of this size, metres."""
    r = rng.uniform(0.012, 0.032) if thick is None else thick
    x, z = width / 2 - r, depth / 2 - r
    splay = rng.choice([0.0, rng.uniform(0.0, 0.08)])
    feet = [(sx, sz) for sx in (-1, 1) for sz in (-1, 1)]
    if rng.random() < 0.5 and splay == 0.0:
        return [shapes.box((sx * x - r, 0, sz * z - r), (sx * x + r, top, sz * z + r)) for sx, sz in feet]
    return [
        shapes.tube([(sx * (x + splay), 0, sz * (z + splay)), (sx * x * 0.9, top, sz * z * 0.9)], r)
        for sx, sz in feet
    ]


def pedestal(rng: Rng, radius: float, top: float) -> list[np.ndarray]:
    """Return a column on a round foot."""
    foot = rng.uniform(0.015, 0.04)
    return [shapes.disc(radius, 0.0, foot), shapes.disc(rng.uniform(0.02, 0.05), foot, top)]


def cantilever(width: float, depth: float, top: float) -> list[np.ndarray]:
    """Return a cantilever base of two bent tubes: along the floor, up at the front, back under the seat."""
    x, z, r = width / 2 - 0.02, depth / 2, 0.014
    sides = [
        shapes.tube([(s * x, r, -z), (s * x, r, z), (s * x, top - r, z), (s * x, top - r, -z)], r)
        for s in (-1, 1)
    ]
    return [*sides, shapes.tube([(-x, r, -z), (x, r, -z)], r)]


def backrest(rng: Rng, width: float, low: float, high: float, z: float) -> list[np.ndarray]:
    """Return a chair's back, slightly reclined: panel, bowed panel, slats, rails or a padded frame."""
    t = rng.uniform(0.015, 0.05)
    kind = rng.choice(["panel", "bowed", "slats", "rails", "padded"])
    gap = rng.uniform(0.0, 0.18)
    if kind == "bowed":
        parts = [shapes.curved_panel(width, high - low - gap, t, rng.uniform(0.02, 0.10), (0, low + gap, z))]
    elif kind == "padded":
        parts = [shapes.cushion((-width / 2, low, z), (width / 2, high, z + t + 0.05), 0.35)]
    else:
        post = rng.uniform(0.012, 0.02)
        ends = [s * (width / 2 - post) for s in (-1, 1)]
        parts = [shapes.box((x - post, low, z), (x + post, high, z + 2 * post)) for x in ends]
        if kind == "panel":
            parts.append(shapes.box((-width / 2, low + gap, z), (width / 2, high, z + t)))
        elif kind == "slats":
            parts.append(shapes.box((-width / 2, high - 0.06, z), (width / 2, high, z + t)))
            for x in np.linspace(*ends, rng.integers(4, 8)):
                parts.append(shapes.box((x - 0.012, low, z), (x + 0.012, high, z + 0.015)))
        else:
            for y in np.linspace(low + 0.12, high - 0.05, rng.integers(2, 5)):
                parts.append(shapes.box((-width / 2, y, z), (width / 2, y + 0.05, z + t)))
    angle = rng.uniform(0.0, 0.26)
    return [shapes.tilted(part, angle, (0, low, z)) for part in parts]


def seat_plate(rng: Rng, width: float, depth: float, top: float) -> list[np.ndarray]:
    """Return a chair's seat: board, board with a cushion, or one thick pad; its upper side at ``top``."""
    x, z = width / 2, depth / 2
    kind = rng.choice(["board", "cushioned", "pad"])
    if kind == "board":
        plate = shapes.box((-x, top - rng.uniform(0.015, 0.04), -z), (x, top, z))
    elif kind == "pad":
        plate = shapes.cushion((-x, top - rng.uniform(0.05, 0.1), -z), (x, top, z), rng.uniform(0.15, 0.4))
    else:
        pad = rng.uniform(0.025, 0.06)
        plate = np.concatenate(
            [
                shapes.box((-x, top - pad - 0.02, -z), (x, top - pad, z)),
                shapes.cushion((-x + 0.02, top - pad, -z + 0.02), (x - 0.02, top, z - 0.02), 0.25),
            ]
        )
    return [shapes.tilted(plate, rng.uniform(0.0, 0.06), (0, top, z))]


def armrests(rng: Rng, width: float, depth: float, seat: float) -> list[np.ndarray]:
    """Return two light armrests beside a seat: pads on posts."""
    height, pad = seat + rng.uniform(0.16, 0.26), rng.uniform(0.03, 0.07)
    reach = depth * rng.uniform(0.25, 0.5)
    parts = []
    for s in (-1, 1):
        x = s * (width / 2 + pad / 2)
        parts.append(shapes.box((x - pad / 2, height - 0.03, -depth / 2), (x + pad / 2, height, reach)))
        post = rng.uniform(0.012, 0.02)
        for z in (reach - 0.04, -depth / 2 + 0.04):
            parts.append(shapes.box((x - post, seat - 0.06, z - post), (x + post, height, z + post)))
    return parts


def chair(rng: Rng) -> list[np.ndarray]:
    """Return a dining or kitchen chair on legs, a pedestal or bent tubes; one in five has armrests."""
    w, d, h = rng.uniform(0.37, 0.52), rng.uniform(0.37, 0.50), rng.uniform(0.42, 0.51)
    parts = seat_plate(rng, w, d, h)
    kind = rng.choice(["legs", "legs", "legs", "pedestal", "cantilever"])
    if kind == "legs":
        parts += legs(rng, w, d, h - 0.02)
    elif kind == "pedestal":
        parts += pedestal(rng, rng.uniform(0.18, 0.26), h - 0.03)
    else:
        parts += cantilever(w, d, h - 0.02)
    parts += backrest(rng, w * rng.uniform(0.85, 1.0), h, h + rng.uniform(0.28, 0.55), -d / 2)
    if rng.random() < 0.2:
        parts += armrests(rng, w, d, h)
    return parts


def armchair(rng: Rng) -> list[np.ndarray]:
    """Return an upholstered armchair, a light one with a wooden frame, or a tub chair with a round shell."""
    kind = rng.choice(["block", "block", "frame", "tub"])
    if kind == "block":
        return upholstered(rng, 1)
    w, d, h = rng.uniform(0.50, 0.64), rng.uniform(0.48, 0.62), rng.uniform(0.36, 0.46)
    if kind == "frame":
        pad = rng.uniform(0.08, 0.15)
        seat = shapes.tilted(
            shapes.cushion((-w / 2, h - pad, -d / 2), (w / 2, h, d / 2), 0.25), 0.06, (0, h, d / 2)
        )
        back = shapes.cushion(
            (-w / 2, h - 0.04, -d / 2 - pad), (w / 2, h + rng.uniform(0.35, 0.5), -d / 2), 0.3
        )
        back = shapes.tilted(back, rng.uniform(0.12, 0.35), (0, h, -d / 2))
        return [seat, back, *armrests(rng, w, d + 0.1, h), *legs(rng, w, d, h - pad)]
    radius, thick = w / 2 + 0.03, rng.uniform(0.05, 0.11)
    shell = shapes.wall(
        radius, thick, rng.choice([0.0, h - 0.15]), h + rng.uniform(0.2, 0.4), rng.uniform(1.4, 2.0)
    )
    base = pedestal(rng, 0.25, h - 0.1) if rng.random() < 0.5 else legs(rng, w, w, h - 0.1)
    return [
        shell,
        shapes.disc(radius, h - 0.14, h - 0.03),
        shapes.cushion((-radius, h - 0.1, -radius), (radius, h, radius + 0.05), 0.8),
        *base,
    ]


def upholstered(rng: Rng, seats: int) -> list[np.ndarray]:
    """Return an upholstered armchair or sofa: a block with a cushion for each seat, a back and usually arms."""
    place, d, h = rng.uniform(0.50, 0.72), rng.uniform(0.50, 0.66), rng.uniform(0.35, 0.47)
    w, pad, foot = place * seats, rng.uniform(0.08, 0.18), rng.choice([0.0, rng.uniform(0.05, 0.16)])
    back_thick, arm = rng.uniform(0.12, 0.26), rng.uniform(0.06, 0.24)
    arm = 0.0 if seats > 1 and rng.random() < 0.12 else arm
    top, x = h + rng.uniform(0.30, 0.55), w / 2
    parts = [shapes.box((-x - arm, foot, -d / 2 - back_thick), (x + arm, h - pad, d / 2), 4)]
    one = rng.random() < 0.3
    edges = np.linspace(-x, x, (1 if one else seats) + 1)
    round_off = rng.uniform(0.12, 0.35)
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        seat = shapes.cushion((a, h - pad - 0.01, -d / 2), (b, h, d / 2 + 0.02), round_off)
        parts.append(shapes.tilted(seat, rng.uniform(0, 0.07), (0, h, d / 2)))
    lean = rng.uniform(0.05, 0.30)
    back = [
        shapes.box((-x - arm, h - pad, -d / 2 - back_thick), (x + arm, top, -d / 2 - back_thick * 0.4), 4)
    ]
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        back.append(
            shapes.cushion((a, h - 0.02, -d / 2 - back_thick * 0.5), (b, top - 0.03, -d / 2 + 0.04), 0.3)
        )
    parts += [shapes.tilted(part, lean, (0, h, -d / 2)) for part in back]
    if arm:
        high = h + rng.uniform(0.12, 0.27)
        for s in (-1, 1):
            a, b = sorted((s * x, s * (x + arm)))
            side = (a, foot, -d / 2 - back_thick), (b, high, d / 2)
            parts.append(shapes.box(*side, 4) if rng.random() < 0.5 else shapes.cushion(*side, 0.2))
    if foot:
        parts += legs(rng, w + 2 * arm - 0.06, d + back_thick - 0.06, foot, 0.025)
    if seats > 1 and rng.random() < 0.15:
        s = rng.choice([-1, 1]) * (x - 0.25)
        pillow = shapes.cushion((s - 0.2, h, -d / 2 + 0.05), (s + 0.2, h + 0.35, -d / 2 + 0.18), 0.5)
        parts.append(shapes.tilted(pillow, 0.3, (0, h, -d / 2)))
    return parts


def sofa(rng: Rng) -> list[np.ndarray]:
    """Return a sofa for two to four."""
    return upholstered(rng, int(rng.integers(2, 5)))


def l_sofa(rng: Rng) -> list[np.ndarray]:
    """Return a corner sofa: a long side and a wing, with a back or as an open chaise, on either side."""
    w, d, h = rng.uniform(1.9, 3.0), rng.uniform(0.55, 0.7), rng.uniform(0.35, 0.45)
    wing, pad, t = rng.uniform(0.55, 1.1), rng.uniform(0.1, 0.18), rng.uniform(0.14, 0.24)
    top, foot, x = h + rng.uniform(0.32, 0.5), rng.choice([0.0, 0.08]), w / 2
    chaise = rng.random() < 0.5
    seat = rng.uniform(0.62, 0.8)
    parts = [
        shapes.box((-x, foot, -d / 2), (x, h - pad, d / 2), 4),
        shapes.box((x - seat, foot, d / 2), (x, h - pad, d / 2 + wing), 4),
        shapes.box((-x, foot, -d / 2 - t), (x, top, -d / 2), 4),
        shapes.cushion((x - seat, h - pad, -d / 2), (x, h, d / 2 + wing), 0.15),
    ]
    edges = np.linspace(-x, x - seat, max(int(round((w - seat) / 0.65)), 1) + 1)
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        parts.append(shapes.cushion((a, h - pad, -d / 2), (b, h, d / 2), 0.2))
    parts.append(shapes.box((-x - 0.16, foot, -d / 2 - t), (-x, h + 0.18, d / 2), 4))
    reach = d / 2 if chaise else d / 2 + wing
    side_top = h + 0.18 if chaise else top
    parts.append(shapes.box((x, foot, -d / 2 - t), (x + 0.18, side_top, reach), 4))
    flip = np.array([rng.choice([-1.0, 1.0]), 1, 1])
    return [part * flip if flip[0] > 0 else (part * flip)[:, ::-1] for part in parts]


def stool(rng: Rng) -> list[np.ndarray]:
    """Return a low stool, round or square, on legs or a column."""
    return _stool(rng, rng.uniform(0.38, 0.52))


def bar_stool(rng: Rng) -> list[np.ndarray]:
    """Return a high stool with a foot ring, sometimes with a low back."""
    h = rng.uniform(0.60, 0.80)
    parts = _stool(rng, h)
    ring = np.linspace(0, 2 * np.pi, 17)
    r, y = rng.uniform(0.12, 0.18), h * rng.uniform(0.3, 0.42)
    parts.append(shapes.tube(np.stack([r * np.sin(ring), np.full(17, y), r * np.cos(ring)], -1), 0.011, 6))
    if rng.random() < 0.4:
        parts += backrest(rng, 0.34, h, h + rng.uniform(0.15, 0.3), -0.19)
    return parts


def _stool(rng: Rng, h: float) -> list[np.ndarray]:
    size, pad = rng.uniform(0.32, 0.46), rng.uniform(0.02, 0.09)
    if rng.random() < 0.5:
        r = size / 2
        round_off = min(pad, 0.02)
        top = shapes.lathe([[1e-6, h - pad], [r, h - pad], [r, h - round_off], [r - 0.02, h], [1e-6, h]])
        size *= 0.75
    else:
        z = size * rng.uniform(0.8, 1.0) / 2
        top = shapes.cushion((-size / 2, h - pad, -z), (size / 2, h, z), 0.2)
    base = (
        pedestal(rng, rng.uniform(0.17, 0.23), h - pad)
        if rng.random() < 0.35
        else legs(rng, size, size, h - pad)
    )
    return [top, *base]


def bench(rng: Rng) -> list[np.ndarray]:
    """Return a bench; one in three has a back."""
    w, d, h = rng.uniform(0.8, 1.8), rng.uniform(0.30, 0.45), rng.uniform(0.40, 0.48)
    if rng.random() < 0.4:
        slats = np.linspace(-d / 2, d / 2, 5)
        parts = [
            shapes.box((-w / 2, h - 0.03, a + 0.004), (w / 2, h, b - 0.004))
            for a, b in zip(slats[:-1], slats[1:], strict=True)
        ]
    else:
        parts = seat_plate(rng, w, d, h)
    if rng.random() < 0.3:
        parts += [
            shapes.box((s * (w / 2 - 0.08) - 0.03, 0, -d / 2), (s * (w / 2 - 0.08) + 0.03, h - 0.02, d / 2))
            for s in (-1, 1)
        ]
    else:
        parts += legs(rng, w * 0.9, d, h - 0.02)
    if rng.random() < 0.35:
        parts += backrest(rng, w, h, h + rng.uniform(0.3, 0.45), -d / 2)
    return parts


def pouf(rng: Rng) -> list[np.ndarray]:
    """Return a low padded block or drum without a back."""
    size, h = rng.uniform(0.40, 0.75), rng.uniform(0.26, 0.46)
    if rng.random() < 0.5:
        r = size / 2
        return [shapes.lathe([[1e-6, 0], [r * 0.9, 0], [r, 0.06], [r, h - 0.05], [r * 0.92, h], [1e-6, h]])]
    z = size * rng.uniform(0.7, 1.0) / 2
    low, high = (-size / 2, 0.0, -z), (size / 2, h, z)
    return [shapes.box(low, high, 4) if rng.random() < 0.4 else shapes.cushion(low, high, 0.2)]
