"""Triangles of the scene with the objects they belong to, and geometric queries on triangles.

Network frame throughout: metres, Y up, +Z forward.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..errors import SampError

LARGEST_MAP = 1e8
"""Metres. Objects within this are at map coordinates; stray vertices are farther away."""

MINIMUM_AREA = 1e-10
"""Square metres. An object with less area has no usable surface."""

LARGEST_COORDINATE = 1e6
"""Metres. Beyond this, the spacing of float32 coordinates exceeds the thickness of a body."""


@dataclass(frozen=True)
class SceneGeometry:
    """All triangles of the scene.

    triangles: (F, 3, 3) corners in metres, network frame. object_ids: (F,) indices into names.
    names: one for each object, also for those without triangles.
    """

    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3)))
    object_ids: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.triangles.ndim != 3 or self.triangles.shape[1:] != (3, 3):
            raise ValueError(f"triangles have shape {self.triangles.shape}, not (F, 3, 3)")
        if self.object_ids.shape != (len(self.triangles),):
            raise ValueError(
                f"{len(self.triangles)} triangles but object ids of shape {self.object_ids.shape}"
            )

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corners (N, 3) of the objects; infinite for objects without triangles."""
        low, high = np.full((2, len(self.names), 3), [[[np.inf]], [[-np.inf]]])
        # Objects follow each other, so that a running minimum is enough.
        starts = np.flatnonzero(np.diff(self.object_ids, prepend=-1))
        if len(starts):
            owners = self.object_ids[starts]
            np.minimum.at(low, owners, np.minimum.reduceat(self.triangles.min(axis=1), starts))
            np.maximum.at(high, owners, np.maximum.reduceat(self.triangles.max(axis=1), starts))
        return low, high

    def __len__(self) -> int:
        return len(self.triangles)

    @classmethod
    def from_objects(cls, objects: Iterable[tuple[str, np.ndarray]]) -> SceneGeometry:
        """Build a scene from (name, triangles (F, 3, 3)) pairs. Raises SampError that names an object with NaN."""
        objects = list(objects)
        for name, triangles in objects:
            require_finite(triangles, name)
        counts = [len(triangles) for _, triangles in objects]
        return cls(
            triangles=np.concatenate([np.zeros((0, 3, 3)), *(triangles for _, triangles in objects)]),
            object_ids=np.repeat(np.arange(len(objects), dtype=np.int32), counts),
            names=tuple(name for name, _ in objects),
        )

    @property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner (2, 3), metres. Raises SampError for an empty scene."""
        return bounds(self.triangles)

    def triangles_of(self, names: Iterable[str]) -> np.ndarray:
        """Return the triangles (F', 3, 3) of the named objects."""
        return self.triangles[self.is_one_of(names)]

    def of(self, names: Iterable[str]) -> np.ndarray:
        """Return `triangles_of`, by the name that scripts outside of the repository use."""
        return self.triangles_of(names)

    def without(self, names: Iterable[str]) -> SceneGeometry:
        """Return the scene without the named objects; the ids of the others are unchanged."""
        keep = ~self.is_one_of(names)
        return SceneGeometry(self.triangles[keep], self.object_ids[keep], self.names)

    def renamed(self, triangles: np.ndarray, name: str) -> SceneGeometry:
        """Return the scene with some triangles, given by their indices, as an object of its own."""
        ids = self.object_ids.copy()
        ids[triangles] = len(self.names)
        return SceneGeometry(self.triangles, ids, (*self.names, name))

    def is_one_of(self, names: Iterable[str]) -> np.ndarray:
        """Return which triangles (F,) are of the named objects."""
        wanted = set(names)
        flags = np.array([name in wanted for name in self.names], dtype=bool)
        return flags[self.object_ids] if len(self.names) else np.zeros(len(self), dtype=bool)


def require_finite(triangles: np.ndarray, name: str) -> None:
    """Raise SampError that names the object if a coordinate is NaN, infinite or beyond LARGEST_COORDINATE."""
    # NaN compares false. Blender stores infinite coordinates as the largest float32.
    farthest = np.abs(triangles).max() if len(triangles) else 0.0
    if not farthest < LARGEST_COORDINATE:
        if farthest < LARGEST_MAP and (np.abs(triangles) > LARGEST_COORDINATE).any(axis=(1, 2)).all():
            raise SampError(
                f"'{name}' is {farthest / 1000:.0f} km from the origin, where Blender's coordinates are too coarse "
                "for a body; move the scene to the origin."
            )
        raise SampError(
            f"'{name}' has vertices whose coordinates are not numbers, or are far too large; delete them."
        )


def require_surface(triangles: np.ndarray, name: str) -> np.ndarray:
    """Return areas (F,) in square metres. Raises SampError that names an object with NaN or without a surface."""
    if len(triangles) == 0:
        raise SampError(f"'{name}' has no faces; choose an object with a surface.")
    require_finite(triangles, name)
    area = areas(triangles)
    if area.sum() < MINIMUM_AREA:
        raise SampError(f"The faces of '{name}' have no area; check its scale and its mesh.")
    return area


def bounds(triangles: np.ndarray) -> np.ndarray:
    """Return lowest and highest corner (2, 3) of triangles (F, 3, 3), metres. Raises SampError without triangles."""
    if len(triangles) == 0:
        raise SampError("The scene has no faces; unhide or add the objects around the character.")
    return np.stack(extent(triangles))


def extent(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lowest and highest corner, (3,) each, of the bounding box of points (..., 3)."""
    # Per column: numpy reduces a short last axis thirty times more slowly.
    columns = np.ascontiguousarray(points.reshape(-1, 3).T)
    return columns.min(axis=1), columns.max(axis=1)


def in_box(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Flag the points (N, 3) in the box from low (3,) to high (3,); numpy reduces a short last axis slowly."""
    x, y, z = ((column >= a) & (column <= b) for column, a, b in zip(points.T, low, high, strict=True))
    return x & y & z


def area_vectors(triangles: np.ndarray) -> np.ndarray:
    """Return normals (F, 3) whose lengths are the triangles' areas in square metres."""
    u = np.ascontiguousarray((triangles[:, 1] - triangles[:, 0]).T)
    v = np.ascontiguousarray((triangles[:, 2] - triangles[:, 0]).T)
    return 0.5 * cross(u, v).T


def areas(triangles: np.ndarray) -> np.ndarray:
    """Return areas (F,) of triangles (F, 3, 3), square metres."""
    x, y, z = area_vectors(triangles).T
    return np.sqrt(x * x + y * y + z * z)


def sample_surface(triangles: np.ndarray, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return random points (count, 3), uniform by area, metres, and the indices of their triangles (count,)."""
    rng = np.random.default_rng(seed)
    area = np.cumsum(_positive_areas(triangles))
    index = np.searchsorted(area, rng.random(count) * area[-1], side="right").clip(0, len(triangles) - 1)
    return _barycentric(triangles[index], rng.random(count), rng.random(count)), index


def spread_over_surface(
    triangles: np.ndarray, count: int, area: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return deterministic points (count, 3), uniform by area, and the indices of their triangles (count,).

    The points advance by equal areas through the list of triangles and follow a low-discrepancy sequence inside each.
    Their mean spacing is the square root of area / count. area: (F,) of the triangles, if known already.
    """
    area = np.cumsum(_positive_areas(triangles) if area is None else area)
    step = np.arange(count)
    index = np.searchsorted(area, (step + 0.5) * (area[-1] / count), side="right").clip(0, len(triangles) - 1)
    return evenly_inside(triangles, index, step), index


def evenly_inside(triangles: np.ndarray, index: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return the points (N, 3) of steps (N,) of a low-discrepancy sequence inside the triangles with indices (N,)."""
    # Powers of the two-dimensional golden ratio: their fractional parts fill the unit square evenly.
    return _barycentric(triangles[index], (0.5 + step * 0.7548776662) % 1, (0.5 + step * 0.5698402910) % 1)


def closest_points(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the exact closest points (N, 3) on triangles (N, 3, 3) to points (N, 3), pairwise; metres."""
    point, corner = np.ascontiguousarray(points.T), by_corner(triangles)
    edge = [corner[(k + 1) % 3] - corner[k] for k in range(3)]
    normal = cross(edge[0], edge[1])
    size = dot(normal, normal)
    height = dot(point - corner[0], normal) / np.maximum(size, 1e-30)
    foot = point - height * normal
    result, least = np.empty_like(point), np.full(len(points), np.inf)
    inside = size > 1e-24
    for start, along in zip(corner, edge, strict=True):
        share = dot(point - start, along) / np.maximum(dot(along, along), 1e-30)
        on_edge = start + np.clip(share, 0, 1) * along
        away = on_edge - point
        gap = dot(away, away)
        np.copyto(result, on_edge, where=gap < least)
        np.minimum(least, gap, out=least)
        inside &= dot(cross(along, foot - start), normal) >= 0
    return np.where(inside, foot, result).T


def by_corner(triangles: np.ndarray) -> np.ndarray:
    """Return the coordinates (3, 3, F) of triangles (F, 3, 3), by corner and axis: numpy is several times slower along
    a short last axis."""
    return np.ascontiguousarray(triangles.transpose(1, 2, 0))


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return dot products (N,) of vectors (3, N)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return cross products (3, N) of vectors (3, N); four times as fast as np.cross."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _positive_areas(triangles: np.ndarray) -> np.ndarray:
    area = areas(triangles)
    if len(area) == 0 or area.sum() < MINIMUM_AREA:
        raise SampError("The object has no surface; choose an object with faces that have an area.")
    return area


def _barycentric(triangles: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    over = u + v > 1
    u, v = np.where(over, 1 - u, u)[:, None], np.where(over, 1 - v, v)[:, None]
    a = triangles[:, 0]
    return a + u * (triangles[:, 1] - a) + v * (triangles[:, 2] - a)
