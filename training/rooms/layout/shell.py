"""The shell of a room: floor, walls with doors and windows, ceiling, rugs. Centred over the origin, floor at y = 0."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...furniture import shapes
from ..classes import Part

THICK = 0.14  # thickness of a wall, metres
DOOR = (0.82, 2.02)  # metres, width and height
WALLS = 4


@dataclass(frozen=True)
class Opening:
    """A door or a window in a wall.

    wall: number of the wall. at: position along the wall from its middle, metres. size: width and height, metres. sill:
    height over the floor, metres.
    """

    kind: str
    wall: int
    at: float
    size: tuple[float, float]
    sill: float


@dataclass
class Shell:
    """The shell of a room. size: width (x), depth (z), height, metres. parts: with the names of their paints."""

    size: tuple[float, float, float]
    openings: list[Opening]
    parts: list[tuple[str, Part]] = field(default_factory=list)


def wall_frame(size: tuple[float, float, float], wall: int) -> tuple[np.ndarray, float, float]:
    """Return the middle (x, z) of a wall's inner foot, the yaw that faces the room, and the wall's length, metres."""
    yaw = (0.0, np.pi / 2, np.pi, -np.pi / 2)[wall]
    width, depth, _ = size
    inwards = np.array([np.sin(yaw), np.cos(yaw)])
    return -inwards * (depth if wall % 2 == 0 else width) / 2, yaw, width if wall % 2 == 0 else depth


def build(size: tuple[float, float, float], windows: tuple[int, int], rng: np.random.Generator) -> Shell:
    """Return a shell with one or two doors and a random number of windows in a range."""
    openings: list[Opening] = []
    for _ in range(1 if size[0] * size[1] < 20 or rng.random() < 0.6 else 2):
        _add(openings, size, "door", DOOR, 0.0, rng)
    sill, high = rng.choice([0.05, rng.uniform(0.75, 1.0)]), rng.uniform(2.0, 2.2)
    for _ in range(int(rng.integers(windows[0], windows[1] + 1))):
        _add(openings, size, "window", (rng.uniform(0.8, 2.0), high - sill), sill, rng)
    shell = Shell(size, openings)
    width, depth, height = size
    x, z = width / 2 + THICK, depth / 2 + THICK
    shell.parts.append(("floor", Part("floor", shapes.box((-x, -0.1, -z), (x, 0.0, z), 4))))
    shell.parts.append(("ceiling", Part("ceiling", shapes.box((-x, height, -z), (x, height + 0.1, z), 4))))
    for wall in range(WALLS):
        _wall(shell, wall)
    return shell


def _add(
    openings: list[Opening], size: tuple[float, float, float], kind: str, extent: tuple[float, float], sill: float,
    rng: np.random.Generator,
) -> None:  # fmt: skip
    """Add an opening clear of corners and other openings, if there is room."""
    for _ in range(12):
        wall = int(rng.integers(WALLS))
        room = wall_frame(size, wall)[2] / 2 - extent[0] / 2 - 0.25
        if room <= 0:
            continue
        at = rng.uniform(-room, room)
        near = [o for o in openings if o.wall == wall and abs(o.at - at) < (o.size[0] + extent[0]) / 2 + 0.2]
        if not near:
            openings.append(Opening(kind, wall, float(at), extent, float(sill)))
            return


def placed(triangles: np.ndarray, middle: np.ndarray, yaw: float, height: float = 0.0) -> np.ndarray:
    """Return triangles of a wall's or an item's own frame in the room's frame."""
    return shapes.turned(triangles, yaw) + [middle[0], height, middle[1]]


def _wall(shell: Shell, wall: int) -> None:
    middle, yaw, length = wall_frame(shell.size, wall)
    height, half = shell.size[2], length / 2 + THICK
    mine = sorted((o for o in shell.openings if o.wall == wall), key=lambda o: o.at)
    solid, at = [], -half
    for o in mine:
        low, high = o.at - o.size[0] / 2, o.at + o.size[0] / 2
        solid.append(shapes.box((at, 0, -THICK), (low, height, 0), 4))
        solid.append(shapes.box((low, o.sill + o.size[1], -THICK), (high, height, 0)))
        if o.sill > 0:
            solid.append(shapes.box((low, 0, -THICK), (high, o.sill, 0)))
        at = high
        for paint, part in (_door if o.kind == "door" else _window)(o):
            shell.parts.append((paint, Part(part.name, placed(part.triangles, middle, yaw))))
    solid.append(shapes.box((at, 0, -THICK), (half, height, 0), 4))
    shell.parts.append((f"wall{wall}", Part("wall", placed(shapes.join(solid), middle, yaw))))
    skirting = [shapes.box((a, 0, 0), (b, 0.07, 0.012)) for a, b in _between_doors(mine, length)]
    if skirting:
        shell.parts.append(("skirting", Part("wall", placed(shapes.join(skirting), middle, yaw))))


def _between_doors(openings: list[Opening], length: float) -> list[tuple[float, float]]:
    ends = [-length / 2]
    for o in openings:
        if o.kind == "door":
            ends += [o.at - o.size[0] / 2 - 0.07, o.at + o.size[0] / 2 + 0.07]
    ends.append(length / 2)
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b > a]


def _rim(o: Opening, thick: float, low: float, high: float) -> list[np.ndarray]:
    """Return the boxes of a frame around an opening."""
    x, top = o.size[0] / 2, o.sill + o.size[1]
    bars = [
        shapes.box((o.at - x - thick, o.sill, low), (o.at - x, top, high)),
        shapes.box((o.at + x, o.sill, low), (o.at + x + thick, top, high)),
        shapes.box((o.at - x - thick, top, low), (o.at + x + thick, top + thick, high)),
    ]
    return bars


def _door(o: Opening) -> list[tuple[str, Part]]:
    x, high = o.size[0] / 2, o.size[1]
    leaf = [shapes.box((o.at - x, 0.0, -0.09), (o.at + x, high, -0.045), 3)]
    knob = o.at + x - 0.09
    handle = [shapes.box((knob - 0.1, 1.02, -0.02), (knob + 0.02, 1.045, 0.0)),
              shapes.box((knob - 0.01, 1.02, -0.045), (knob + 0.01, 1.045, 0.0))]  # fmt: skip
    return [
        ("leaf", Part("door", shapes.join(leaf))),
        ("frame", Part("door", shapes.join(_rim(o, 0.06, -THICK, 0.015)))),
        ("handle", Part("door", shapes.join(handle))),
    ]


def _window(o: Opening) -> list[tuple[str, Part]]:
    x, top, rim = o.size[0] / 2, o.sill + o.size[1], 0.05
    bars = [
        shapes.box((o.at - x, o.sill, -0.09), (o.at - x + rim, top, -0.04)),
        shapes.box((o.at + x - rim, o.sill, -0.09), (o.at + x, top, -0.04)),
        shapes.box((o.at - x, o.sill, -0.09), (o.at + x, o.sill + rim, -0.04)),
        shapes.box((o.at - x, top - rim, -0.09), (o.at + x, top, -0.04)),
    ]
    if o.size[0] > 1.1:
        bars.append(shapes.box((o.at - rim / 2, o.sill, -0.09), (o.at + rim / 2, top, -0.04)))
    if o.sill > 0.3:
        bars.append(shapes.box((o.at - x - 0.04, o.sill - 0.03, -0.04), (o.at + x + 0.04, o.sill, 0.09)))
    a, b = (o.at - x, o.sill, -0.07), (o.at + x, top, -0.065)
    return [("sash", Part("window", shapes.join(bars))), ("pane", Part("window", shapes.box(a, b, 1)))]
