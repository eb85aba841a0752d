"""Place items without overlaps, with free doors and free space in front of seats and storage."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .shell import Shell, wall_frame
from .stock import Item

AIR = 0.03  # gap (m) between items


@dataclass(frozen=True)
class Rectangle:
    """A rotated rectangle in the floor plane: centre (2,) and half sizes (2,) in metres, yaw in radians."""

    centre: np.ndarray
    half: np.ndarray
    yaw: float

    def corners(self) -> np.ndarray:
        """Return the corners (4, 2), metres."""
        signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * self.half
        return self.centre + turned(signs, self.yaw)

    def overlaps(self, other: Rectangle) -> bool:
        """Return whether both rectangles share an area."""
        mine, theirs = self.corners(), other.corners()
        for yaw in (self.yaw, other.yaw):
            for axis in (np.array([np.cos(yaw), -np.sin(yaw)]), np.array([np.sin(yaw), np.cos(yaw)])):
                a, b = mine @ axis, theirs @ axis
                if a.max() <= b.min() or b.max() <= a.min():
                    return False
        return True


def turned(points: np.ndarray, yaw: float) -> np.ndarray:
    """Return points (..., 2), x and z, turned about the vertical axis by yaw, radians."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([points[..., 0] * c + points[..., 1] * s, -points[..., 0] * s + points[..., 1] * c], -1)


@dataclass(frozen=True)
class Placed:
    """An item with its placement: x, y, z in metres and yaw in radians."""

    item: Item
    x: float
    y: float
    z: float
    yaw: float

    @property
    def footprint(self) -> Rectangle:
        """Bounding rectangle of the item in the floor plane."""
        low, high = self.item.box
        middle = turned((low + high)[[0, 2]] / 2, self.yaw)
        return Rectangle(np.array([self.x, self.z]) + middle, (high - low)[[0, 2]] / 2, self.yaw)

    def at(self, x: float, z: float) -> np.ndarray:
        """Convert x and z from the item's frame to the room's (2,), metres."""
        return turned(np.array([x, z]), self.yaw) + [self.x, self.z]


@dataclass
class Plan:
    """The items of a room with their placements. taken: footprints. kept: areas that stay free."""

    shell: Shell
    rng: np.random.Generator
    placed: list[Placed] = field(default_factory=list)
    taken: list[Rectangle] = field(default_factory=list)
    kept: list[Rectangle] = field(default_factory=list)

    def __post_init__(self) -> None:
        for o in self.shell.openings:
            if o.kind == "door":
                middle, yaw, _ = wall_frame(self.shell.size, o.wall)
                centre = middle + turned(np.array([o.at, 0.5]), yaw)
                self.kept.append(Rectangle(centre, np.array([0.5, 0.5]), yaw))

    def fits(self, rectangle: Rectangle, air: float = AIR) -> bool:
        """Return whether a footprint is inside the room and free, with a gap of ``air`` metres."""
        width, depth, _ = self.shell.size
        corners = rectangle.corners()
        if (np.abs(corners) > np.array([width, depth]) / 2 - 0.01).any():
            return False
        wide = Rectangle(rectangle.centre, rectangle.half + air, rectangle.yaw)
        return not any(wide.overlaps(other) for other in self.taken + self.kept)

    def put(
        self, item: Item | None, x: float, z: float, yaw: float, air: float = AIR, y: float = 0.0
    ) -> Placed | None:
        """Place an item; return it, or None where it does not fit."""
        if item is None:
            return None
        placed = Placed(item, float(x), float(y), float(z), float(yaw))
        if not self.fits(placed.footprint, air):
            return None
        self.placed.append(placed)
        self.taken.append(placed.footprint)
        return placed

    def along_wall(
        self, item: Item | None, walls: list[int] | None = None, gap: float = 0.02, air: float = AIR,
        front: float = 0.0, corner: bool = False, tries: int = 24,
    ) -> Placed | None:  # fmt: skip
        """Place an item with its back to a wall; return it, or None.

        front: metres in front of it that stay free. corner: whether it is next to another wall.
        """
        if item is None:
            return None
        low, high = item.box
        for _ in range(tries):
            wall = int(self.rng.choice(walls if walls is not None else range(4)))
            middle, yaw, length = wall_frame(self.shell.size, wall)
            room = length / 2 - (high[0] - low[0]) / 2 - 0.03
            if room < 0 or self._before_window(wall, item):
                continue
            at = self.rng.choice([-room, room]) if corner else self.rng.uniform(-room, room)
            at -= (low[0] + high[0]) / 2
            x, z = middle + turned(np.array([at, gap - low[2]]), yaw)
            placed = self.put(item, x, z, yaw, air)
            if placed is not None:
                if front:
                    self.keep_front(placed, front)
                return placed
        return None

    def _before_window(self, wall: int, item: Item) -> bool:
        """Return whether to avoid a wall with windows for a high item, which holds in nine of ten cases."""
        return (
            item.size[1] > 1.3
            and any(o.kind == "window" and o.wall == wall for o in self.shell.openings)
            and self.rng.random() < 0.9
        )

    def keep_front(self, placed: Placed, depth: float, width: float = 0.0) -> None:
        """Keep an area of ``depth`` metres in front of an item free; width: metres, 0 for the item's."""
        low, high = placed.item.box
        half = width / 2 if width else (high[0] - low[0]) / 2
        centre = placed.at((low[0] + high[0]) / 2, high[2] + depth / 2 + 0.01)
        self.kept.append(Rectangle(centre, np.array([half, depth / 2]), placed.yaw))

    def on_wall(self, item: Item | None, low: float, high: float, tries: int = 16) -> Placed | None:
        """Hang an item on a wall, clear of doors, windows and high items; return it, or None.

        low, high: range of heights of its lower edge, metres.
        """
        if item is None:
            return None
        for _ in range(tries):
            wall = int(self.rng.integers(4))
            middle, yaw, length = wall_frame(self.shell.size, wall)
            half = item.size[0] / 2
            if length / 2 - half < 0.1:
                continue
            at = self.rng.uniform(-length / 2 + half + 0.05, length / 2 - half - 0.05)
            y = min(self.rng.uniform(low, high), self.shell.size[2] - item.size[1] - 0.1)
            clear = all(
                o.wall != wall or abs(o.at - at) > o.size[0] / 2 + half + 0.1 for o in self.shell.openings
            )
            x, z = middle + turned(np.array([at, 0.004]), yaw)
            placed = Placed(item, float(x), float(y), float(z), yaw)
            zone = Rectangle(placed.footprint.centre, np.array([half + 0.03, 0.05]), yaw)
            behind = [
                p for p in self.placed if p.y + p.item.box[1][1] > y - 0.02 and zone.overlaps(p.footprint)
            ]
            if clear and not behind:
                self.placed.append(placed)
                return placed
        return None

    def on_top(self, below: Placed, item: Item, place: tuple[float, float], yaw: float) -> Placed | None:
        """Place an item on another, at (x, z) in the frame of the lower one; None where it is not fully supported."""
        y = below.item.top(*place)
        x, z = below.at(*place)
        if not np.isfinite(y) or y < 0.25:
            return None
        placed = Placed(item, float(x), float(below.y + y + 0.001), float(z), float(below.yaw + yaw))
        foot = placed.footprint
        others = [p for p in self.placed if p.y > 0 and p is not below]
        if any(foot.overlaps(p.footprint) for p in others):
            return None
        # All corners need support, so that nothing projects over the edge.
        local = turned(foot.corners() - [below.x, below.z], -below.yaw)
        if any(abs(below.item.top(*corner) - y) > 0.02 for corner in local):
            return None
        self.placed.append(placed)
        return placed
