"""The surfaces of a seat: heights of the seat, the face of its back, and its armrests, in the seat frame.

The seat frame has its origin on the floor below a goal, Y up, and +Z along the goal's direction; metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import grey_closing, map_coordinates

from ....samp_addon import rotation
from ....samp_addon.motion import Goal
from ....samp_addon.scene.seats.postures import SEAT_TO_PELVIS

CELL = 0.015
SEAT_SPAN = ((-0.45, 0.45), (-0.75, 0.75))  # x and z of the height map
BACK_SPAN = ((-0.21, 0.21), (0.03, 0.85))  # x, and y over the seat, of the back map
STEP = 0.09  # height (m) over the seat up to which a surface supports the body
WALL = 0.15  # height (m) over the seat above which a column is a back or an armrest
NOTHING = -9.0  # value of empty cells
REACH_BACK = (-0.75, 0.12)  # range of z in which a back is searched
ARMREST = (0.12, 0.32)  # heights (m) of an armrest over the seat


@dataclass(frozen=True)
class Frame:
    """A seat frame in its piece's frame: origin (3,) on the floor, metres; yaw, radians."""

    origin: np.ndarray
    yaw: float

    @classmethod
    def of(cls, goal: Goal) -> Frame:
        """Return the seat frame of a goal."""
        origin = np.array([goal.position[0], 0.0, goal.position[2]])
        return cls(origin, float(np.arctan2(goal.direction[0], goal.direction[2])))

    def to_seat(self, points: np.ndarray) -> np.ndarray:
        """Convert points (..., 3) from the piece's frame to the seat frame."""
        turn = rotation.quaternion_to_matrix(rotation.about_y(-self.yaw))
        return (points - self.origin) @ turn.T

    def to_piece(self, points: np.ndarray) -> np.ndarray:
        """Convert points (..., 3) from the seat frame to the piece's frame."""
        turn = rotation.quaternion_to_matrix(rotation.about_y(self.yaw))
        return points @ turn.T + self.origin

    @property
    def placement(self) -> tuple[float, float, float]:
        """(x, z, yaw) of the piece in the seat frame, as Sequence.placement."""
        at = self.to_seat(np.zeros(3))
        return float(at[0]), float(at[2]), -self.yaw


@dataclass(frozen=True, eq=False)
class SeatSurface:
    """The surfaces of a seat, in its frame, metres.

    level: height of the seat. heights: (X, Z) of the supporting surface, NOTHING where there is none. back: (X, Y) z of
    the back's face, NOTHING where there is none. points: (N, 3) samples of the piece.
    """

    frame: Frame
    level: float
    heights: np.ndarray
    back: np.ndarray
    points: np.ndarray

    @classmethod
    def of(cls, surface: np.ndarray, goal: Goal) -> SeatSurface:
        """Return the surface of a piece around a sitting goal, from samples (N, 3) of it."""
        frame = Frame.of(goal)
        points = frame.to_seat(surface)
        level = float(goal.position[1]) - SEAT_TO_PELVIS
        heights = _raster(points, SEAT_SPAN, (0, 2), points[:, 1], points[:, 1] < level + STEP)
        tops = _raster(points, SEAT_SPAN, (0, 2), points[:, 1], points[:, 1] < level + 1.0)
        heights = grey_closing(heights, 3)
        # A column far above the seat belongs to a back or an armrest; the seat ends in front of it.
        heights = np.where((tops > level + WALL) & (heights > level), level, heights)
        shifted = points - [0.0, level, 0.0]
        behind = (points[:, 2] > REACH_BACK[0]) & (points[:, 2] < REACH_BACK[1])
        back = _raster(shifted, BACK_SPAN, (0, 1), points[:, 2], behind)
        back = grey_closing(back, (7, 9))
        return cls(frame, level, heights, back, points)

    def height_at(self, x: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the height of the supporting surface at (x, z), metres; NOTHING where there is none."""
        return _look(self.heights, SEAT_SPAN, x, z)

    def back_at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return z of the back's face at (x, height over the floor), metres; NOTHING where there is none."""
        return _look(self.back, BACK_SPAN, x, y - self.level)

    @cached_property
    def edge(self) -> float:
        """z of the front edge of the seat, metres."""
        return self._ends[1]

    @cached_property
    def rear(self) -> float:
        """z of the rear edge of the seat, or of its back's face, metres."""
        return max(self._ends[0], self.rest if self.backed else NOTHING)

    @cached_property
    def _ends(self) -> tuple[float, float]:
        x = np.arange(-0.12, 0.121, 0.03)
        z = np.arange(SEAT_SPAN[1][0], SEAT_SPAN[1][1], 0.01)
        on = self.height_at(*np.meshgrid(x, z, indexing="ij")) > self.level - 0.035
        share = on.mean(0) > 0.6
        middle = int(np.argmin(np.abs(z)))
        if not share[middle]:
            return 0.0, 0.0
        gaps = np.flatnonzero(~share)
        before, after = gaps[gaps < middle], gaps[gaps > middle]
        first = z[before[-1] + 1] if len(before) else z[0]
        last = z[after[0] - 1] if len(after) else z[-1]
        return float(first), float(last)

    @cached_property
    def _rest_cells(self) -> np.ndarray:
        x, y = np.meshgrid(np.arange(-0.12, 0.121, 0.03), np.arange(0.14, 0.45, 0.03), indexing="ij")
        return self.back_at(x, y + self.level)

    @cached_property
    def backed(self) -> bool:
        """Whether there is a back to lean against."""
        return bool((self._rest_cells > NOTHING / 2).mean() > 0.3)

    @cached_property
    def rest(self) -> float:
        """z of the back's face, median, metres."""
        cells = self._rest_cells[self._rest_cells > NOTHING / 2]
        return float(np.median(cells)) if len(cells) else NOTHING

    @cached_property
    def armrests(self) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Left and right armrest: (4,) x of its centre, height, z of its front and of its rear end; None without."""
        return self._armrest(1.0), self._armrest(-1.0)

    def _armrest(self, side: float) -> np.ndarray | None:
        x = side * self.points[:, 0]
        beside = (x > 0.20) & (x < 0.48) & (self.points[:, 2] > self.rear + 0.05)
        over = self.points[:, 1] - self.level
        some = self.points[beside & (over > ARMREST[0]) & (over < ARMREST[1])]
        taller = (beside & (over > ARMREST[1] + 0.05)).sum()
        if len(some) < 60 or taller > 0.3 * len(some):
            return None
        top = float(np.percentile(some[:, 1], 97))
        pad = some[some[:, 1] > top - 0.03]
        front, rear = np.percentile(pad[:, 2], [97, 3])
        if front - rear < 0.12 or front < self.edge - 0.35:
            return None
        inner = side * np.percentile(side * pad[:, 0], 3)
        outer = side * np.percentile(side * pad[:, 0], 97)
        middle = inner + side * min(abs(outer - inner) / 2, 0.05)
        return np.array([middle, top, front, rear])


def _shape(span: tuple) -> tuple[int, int]:
    return tuple(int(round((b - a) / CELL)) + 1 for a, b in span)


def _raster(
    points: np.ndarray, span: tuple, axes: tuple[int, int], values: np.ndarray, some: np.ndarray
) -> np.ndarray:
    """Return the largest of the values (N,) of points (N, 3) in each cell of a grid over two axes."""
    shape = _shape(span)
    at = [
        np.round((points[:, axis] - low) / CELL).astype(int)
        for axis, (low, _) in zip(axes, span, strict=True)
    ]
    inside = some & (at[0] >= 0) & (at[0] < shape[0]) & (at[1] >= 0) & (at[1] < shape[1])
    grid = np.full(shape, NOTHING)
    np.maximum.at(grid, (at[0][inside], at[1][inside]), values[inside])
    return grid


def _look(grid: np.ndarray, span: tuple, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the values of a grid at (a, b), interpolated linearly between non-empty cells."""
    at = np.stack([(a - span[0][0]) / CELL, (b - span[1][0]) / CELL])
    nearest = map_coordinates(grid, at, order=0, mode="constant", cval=NOTHING)
    linear = map_coordinates(grid, at, order=1, mode="constant", cval=NOTHING)
    # Next to an edge, linear interpolation would pull the value towards NOTHING.
    return np.where(linear > nearest - 0.06, linear, nearest)
