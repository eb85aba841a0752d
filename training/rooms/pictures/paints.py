"""Random colours, patterns and light for each picture."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass

import numpy as np

from ..classes import CLASS, PERSON
from ..layout.room import PANE, Room

OUTSIDE = np.iinfo(np.int16).max
# Paints of people: -1 and below, in the order of body.human.MATERIALS.
PEOPLE = 7
_HUES = {  # hue, saturation and value, each between two bounds, by the kind of material
    "wood": ((0.05, 0.11), (0.25, 0.65), (0.25, 0.8)), "white": ((0.08, 0.17), (0.0, 0.1), (0.75, 0.95)),
    "grey": ((0.0, 1.0), (0.0, 0.08), (0.15, 0.75)), "cloth": ((0.0, 1.0), (0.1, 0.65), (0.2, 0.8)),
    "pale": ((0.0, 1.0), (0.03, 0.25), (0.6, 0.92)), "bright": ((0.0, 1.0), (0.4, 0.9), (0.4, 0.9)),
    "muted": ((0.0, 1.0), (0.1, 0.4), (0.35, 0.7)), "leaf": ((0.22, 0.38), (0.4, 0.8), (0.2, 0.55)),
    "black": ((0.0, 1.0), (0.0, 0.2), (0.04, 0.15)),
}  # fmt: skip
_MATERIALS = {
    "floor": ("wood", "wood", "grey", "pale", "wood"), "wall": ("white", "white", "pale", "pale", "muted"),
    "ceiling": ("white",), "door": ("white", "wood", "grey"), "window": ("white", "wood", "grey"),
    "table": ("wood", "wood", "white", "grey", "black"),
    "chair": ("wood", "cloth", "white", "black", "bright"), "sofa": ("cloth", "cloth", "grey", "wood"),
    "bed": ("white", "pale", "cloth", "wood"), "cupboard": ("wood", "white", "wood", "pale", "grey"),
    "shelf": ("wood", "white", "black"), "board": ("white", "bright", "black", "wood"),
    "clutter": ("bright", "cloth", "white", "leaf", "black", "wood"),
}  # fmt: skip


@dataclass
class Paint:
    """Colours (2, 3) in linear light, a pattern with its scale (1/m) and rotation (radians), and gloss, 0 to 1."""

    colours: np.ndarray
    pattern: str
    scale: float
    turn: float
    shine: float


@dataclass
class Light:
    """The light of a room, in linear colours.

    sun: direction towards it (3,), with sun_colour (3,). lamps: positions (L, 3), with lamp_colours (L, 3). sky: colour
    (3,) outside. fill: ambient light (3,). exposure: of the camera.
    """

    sun: np.ndarray
    sun_colour: np.ndarray
    lamps: np.ndarray
    lamp_colours: np.ndarray
    sky: np.ndarray
    fill: np.ndarray
    exposure: float


def colour(kind: str, rng: np.random.Generator) -> np.ndarray:
    """Return a random colour (3,) of a kind of material, linear light."""
    hue, saturation, value = (rng.uniform(*bounds) for bounds in _HUES[kind])
    return np.array(colorsys.hsv_to_rgb(hue % 1.0, saturation, value)) ** 2.2


def draw(room: Room, rng: np.random.Generator) -> dict[int, Paint]:
    """Return random paints by number, for the room and for people (negative numbers)."""
    paints, walls = {}, _paint("wall", rng)
    klass = {int(p): int(c) for p, c in zip(*_first(room.paints, room.classes), strict=True)}
    family: dict[tuple[int, str], Paint] = {}
    for number, name in enumerate(room.paint_names):
        kind = next((k for k, v in CLASS.items() if v == klass.get(number)), "clutter")
        if name.startswith("wall"):
            # One wall in eight has another colour.
            paints[number] = _paint("wall", rng) if rng.random() < 0.12 else walls
        elif kind in ("cupboard", "shelf"):
            # Cupboards of a room share their paints.
            key = (CLASS[kind], name.split("/")[-1])
            paints[number] = family.setdefault(key, _paint(kind, rng))
        else:
            paints[number] = _paint(kind, rng)
        if name.startswith("plant/1"):
            paints[number] = Paint(np.stack([colour("leaf", rng)] * 2), "plain", 1.0, 0.0, 0.1)
        if name == PANE:
            paints[number] = Paint(np.ones((2, 3)) * 0.9, "plain", 1.0, 0.0, 0.6)
    for k in range(PEOPLE):
        paints[-1 - k] = _person(k, rng)
    return paints


def _first(values: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    numbers, index = np.unique(values, return_index=True)
    return numbers, others[index]


def _paint(kind: str, rng: np.random.Generator) -> Paint:
    material = str(rng.choice(_MATERIALS[kind]))
    first = colour(material, rng)
    second = first * rng.uniform(0.55, 0.9)
    pattern, scale = "plain", 1.0
    if material == "wood":
        pattern, scale = ("planks", rng.uniform(5, 11)) if kind == "floor" else ("grain", rng.uniform(10, 40))
    elif kind == "floor":
        pattern, scale = str(rng.choice(["tiles", "noise", "plain"])), rng.uniform(1.5, 4.0)
    elif material in ("cloth", "bright") and rng.random() < 0.45:
        pattern, scale = str(rng.choice(["stripes", "checks", "noise"])), rng.uniform(4, 20)
        second = colour(str(rng.choice(["cloth", "pale"])), rng)
    elif kind == "wall" and rng.random() < 0.15:
        pattern, scale = str(rng.choice(["stripes", "noise"])), rng.uniform(3, 10)
        second = first * rng.uniform(0.75, 0.95)
    shine = (
        rng.uniform(0.0, 0.5) if material in ("wood", "black", "white", "grey") and kind != "wall" else 0.0
    )
    return Paint(np.stack([first, second]), pattern, float(scale), float(rng.uniform(0, np.pi)), float(shine))


_SKINS = np.array(
    [[0.80, 0.58, 0.46], [0.70, 0.46, 0.34], [0.52, 0.33, 0.22], [0.34, 0.2, 0.13], [0.86, 0.66, 0.55]]
)


def _person(part: int, rng: np.random.Generator) -> Paint:
    """Return the paint of a person's part: skin, clothes, trousers, shoes, hair, eyes, pupils."""
    if part == 0:
        base = _SKINS[rng.integers(len(_SKINS))] ** 2.2
        return Paint(np.stack([base, base]), "plain", 1.0, 0.0, 0.1)
    kinds = {
        1: ("cloth", "white", "grey", "bright", "black"),
        2: ("grey", "cloth", "black"),
        3: ("black", "grey", "wood"),
    }
    if part in kinds:
        paint = _paint("sofa", rng)
        first = colour(str(rng.choice(kinds[part])), rng)
        second = first * 0.6 if rng.random() < 0.75 or part != 1 else colour("pale", rng)
        pattern = str(rng.choice(["plain", "plain", "stripes", "checks"])) if part == 1 else "plain"
        return Paint(np.stack([first, second]), pattern, rng.uniform(10, 30), paint.turn, 0.0)
    base = {4: colour(str(rng.choice(["wood", "black", "grey"])), rng) * 0.6, 5: np.ones(3) * 0.8}.get(
        part, np.ones(3) * 0.02
    )
    return Paint(np.stack([base, base]), "plain", 1.0, 0.0, 0.2)


def albedo(
    paints: dict[int, Paint], numbers: np.ndarray, points: np.ndarray, normals: np.ndarray
) -> np.ndarray:
    """Return the colours (N, 3) of surface points (N, 3) with paints (N,); patterns follow the dominant plane."""
    out = np.full((len(numbers), 3), 0.5)
    for number in np.unique(numbers):
        paint = paints.get(int(number))
        if paint is None:
            continue
        rows = np.flatnonzero(numbers == number)
        share = _pattern(paint, points[rows], normals[rows])[:, None]
        out[rows] = paint.colours[0] * (1 - share) + paint.colours[1] * share
    return out


def _pattern(paint: Paint, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the share (N,) of the second colour."""
    if paint.pattern == "plain":
        return np.zeros(len(points))
    axis = np.abs(normals).argmax(1)
    rows = np.arange(len(points))
    u, v = points[rows, (axis + 1) % 3], points[rows, (axis + 2) % 3]
    c, s = np.cos(paint.turn), np.sin(paint.turn)
    if paint.pattern not in ("grain", "planks", "tiles"):
        u, v = u * c + v * s, v * c - u * s
    u, v = u * paint.scale, v * paint.scale
    return _PATTERNS[paint.pattern](u, v)


def _planks(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    row = np.floor(u)
    board = np.floor(v * 0.12 + _hash(row, 0 * row) * 7)
    grain = 0.6 * _hash(row, board) + 0.2 * np.sin(u * 23 + 3 * np.sin(v * 2)) ** 2
    return np.where(u % 1 < 0.03, 1.0, grain)


def _hash(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.abs(np.sin(a * 127.1 + b * 311.7) * 43758.5453) % 1.0


def _noise(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return smooth noise (N,), 0 to 1."""
    x, y = np.floor(u), np.floor(v)
    fx, fy = u - x, v - y
    fx, fy = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy)
    top = _hash(x, y) * (1 - fx) + _hash(x + 1, y) * fx
    low = _hash(x, y + 1) * (1 - fx) + _hash(x + 1, y + 1) * fx
    return top * (1 - fy) + low * fy


_PATTERNS = {
    "stripes": lambda u, v: (np.floor(u) % 2).astype(float),
    "checks": lambda u, v: ((np.floor(u) + np.floor(v)) % 2).astype(float) * 0.8,
    "tiles": lambda u, v: ((u % 1 < 0.04) | (v % 1 < 0.04)).astype(float),
    "planks": _planks,
    "grain": lambda u, v: 0.5 + 0.5 * np.sin(u + 1.5 * np.sin(v * 0.23) + 0.7 * np.sin(u * 0.31)),
    "noise": _noise,
}


def light(room: Room, rng: np.random.Generator) -> Light:
    """Return random light: daylight through the windows, lamps in the evening, or both."""
    height = rng.uniform(0.25, 1.0)
    yaw = rng.uniform(0, 2 * np.pi)
    sun = np.array([np.sin(yaw) * np.cos(height), np.sin(height), np.cos(yaw) * np.cos(height)])
    day = rng.choice([0.0, rng.uniform(0.4, 1.0)], p=[0.25, 0.75])
    count = int(rng.integers(1, 4))
    half = np.array(room.size)[[0, 2, 1]] * np.array([0.35, 1.0, 0.35])
    lamps = np.column_stack([
        rng.uniform(-half[0], half[0], count), rng.uniform(0.8, 0.97, count) * room.size[2],
        rng.uniform(-0.35, 0.35, count) * room.size[1],
    ])  # fmt: skip
    warm = np.array([1.0, rng.uniform(0.75, 1.0), rng.uniform(0.5, 1.0)])
    power = rng.uniform(0.4, 1.6, (count, 1)) * (1.2 if day == 0 else rng.choice([0.15, 1.0]))
    blue = np.array([rng.uniform(0.7, 1.0), rng.uniform(0.85, 1.0), 1.0])
    return Light(
        sun, day * rng.choice([0.0, rng.uniform(1.5, 5.0)]) * np.array([1.0, 0.93, 0.82]), lamps, power * warm,
        blue * (0.04 + day * rng.uniform(1.0, 3.0)), blue * (0.1 + 0.35 * day) + warm * 0.12, rng.uniform(0.75, 1.3),
    )  # fmt: skip


def is_person(classes: np.ndarray) -> np.ndarray:
    """Flag pixels on people."""
    return classes == PERSON
