"""A room prepared for composing episodes: navmesh, clearance, placed uses, collision queries."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ....samp_addon import skeleton
from ....samp_addon.errors import PathError
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.scene import geometry
from ....samp_addon.scene.navmesh import navmesh, path
from ...mocap.events import turned
from ..classes import CLASS
from ..layout.room import Room
from ..layout.stock import Item
from ..uses.tables import Tops, with_hands_on
from ..uses.use import Use, Uses
from .bank import flat_root
from .depth import SOFT, bone_points

RADIUS, HEIGHT = 0.26, 1.75  # radius and height (m) of a walking body
SPACING = 0.03  # metres between the samples of surfaces
FAR = 0.13  # limit (m) of distance queries, a little more than the largest of RADII
STEP, FINE = 4, 2  # strides of the checked frames of uses and of finished episodes
KEYS = [skeleton.INDEX[n] for n in ("pelvis", "left_ankle", "right_ankle", "left_foot", "right_foot", "head",
        "left_wrist", "right_wrist")]  # fmt: skip
DEEP = 0.02  # largest allowed depth, metres
CLOSE = 8  # frames before sitting down that are part of a use
ON_TABLES = 0.75  # share of the places in front of a table with hands on it


@dataclass(frozen=True)
class PlacedUse:
    """A use in the room's frame. item: number of the piece. flat: (T, 3) smoothed x, z, yaw."""

    item: int
    use: Use
    root: np.ndarray
    rotations: np.ndarray
    flat: np.ndarray

    @cached_property
    def keys(self) -> np.ndarray:
        """Positions (T, K, 3) of the joints KEYS, metres."""
        joints, _ = skeleton.forward_kinematics(self.root, self.rotations, skeleton.default_rest_joints())
        return joints[:, KEYS]

    def cut(self, start: int, stop: int) -> PlacedUse:
        """Return the frames start .. stop - 1."""
        use, part = self.use, slice(start, stop)
        frames = {
            name: getattr(use, name) - start if getattr(use, name) >= 0 else -1
            for name in ("down", "seated", "seat_end", "up_end")
        }
        arrays = ("root", "rotations", "labels", "feet", "hands", "source")
        less = replace(use, **frames, **{name: getattr(use, name)[part] for name in arrays})
        return PlacedUse(self.item, less, self.root[part], self.rotations[part], self.flat[part])

    @property
    def place(self) -> tuple[int, int]:
        """Number of the piece and of the place on it."""
        return self.item, self.use.place


class Scene:
    """A furnished room prepared for episodes. items: by name. uses: source of sits and lies, None for none."""

    def __init__(self, room: Room, items: dict[str, Item], uses: Uses | None) -> None:
        self.room = room
        inside = ~np.isin(room.classes, [CLASS["ceiling"]])
        agent = navmesh.Agent(radius=RADIUS, height=HEIGHT)
        self.mesh = navmesh.build(room.triangles[inside], agent)
        parts = self.mesh.island_of(self.mesh.walkable)
        self.island = int(np.bincount(parts).argmax())
        points = self.mesh.points[parts == self.island]
        low = points[:, 1] < 0.1
        self.free = points[low]
        clearance = self.mesh.ground.clearance[self.mesh.walkable[parts == self.island]][low]
        self.clearance = np.minimum(clearance, 0.6)
        ground = self.mesh.ground
        self._raster = np.zeros(ground.grid.shape[:2])
        floor = ground.places.height < 0.1
        np.maximum.at(self._raster, (ground.places.x[floor], ground.places.z[floor]), ground.clearance[floor])
        self.gaps: dict[tuple[int, int], np.ndarray] = {}
        self.captured: dict[int, float] = {}
        self.too_deep: Counter[int] = Counter()
        self._items = items
        self._trees: dict[int, cKDTree] = {}
        self.placed_uses = self._placed_uses(items, uses) if uses is not None else []

    def rises(self, placed: PlacedUse) -> list[PlacedUse]:
        """Return the rises at the place of a use."""
        return [
            up for up in self.placed_uses
            if up.place == placed.place and up.use.action == placed.use.action and up.use.up_end >= 0
            and up.use.seat_end > 12
        ]  # fmt: skip

    def clearance_at(self, places: np.ndarray) -> np.ndarray:
        """Return the distance (...), metres, of positions (..., 2) on the floor from obstacles, 0 inside them."""
        grid = self.mesh.ground.grid
        at = np.floor((places - grid.corner[[0, 2]]) / grid.cell).astype(int)
        inside = ((at >= 0) & (at < self._raster.shape)).all(-1)
        at = np.clip(at, 0, np.array(self._raster.shape) - 1)
        return np.where(inside, self._raster[at[..., 0], at[..., 1]], 0.0)

    @cached_property
    def surface(self) -> tuple[cKDTree, np.ndarray]:
        """Tree of the surface samples of all obstacles, and the object of each sample."""
        room = self.room
        floor = np.isin(room.classes, [CLASS["floor"], CLASS["ceiling"]])
        chosen = ~floor & (room.triangles[..., 1].min(1) < 1.9)
        triangles, objects = room.triangles[chosen], room.objects[chosen]
        area = np.linalg.norm(
            np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=-1
        ).sum()
        points, face = geometry.sample_surface(
            triangles, int(min(area / 2 / SPACING**2 * 2, 250_000)), seed=0
        )
        return _tree(points), objects[face]

    def _without(self, number: int) -> cKDTree:
        """Return the tree of all surfaces except those of one piece."""
        if number not in self._trees:
            tree, objects = self.surface
            self._trees[number] = _tree(np.asarray(tree.data)[objects != number])
        return self._trees[number]

    def _placed_uses(self, items: dict[str, Item], uses: Uses) -> list[PlacedUse]:
        found, tops = [], Tops.of(self.room)
        for number in self.room.seats:
            item = items.get(self.room.names[number])
            if item is None:
                continue
            x, y, z, yaw = self.room.places[number]
            if y > 0.01:
                continue
            for use in uses.of(item):
                root, rotations = turned(use.root, use.rotations, yaw, np.array([x, 0.0, z]))
                placed = PlacedUse(number, use, root, rotations, flat_root(root, rotations))
                clear = self._open_part(placed)
                if clear is not None:
                    found.append(self._at_table(clear, tops))
        return found

    def _at_table(self, placed: PlacedUse, tops: Tops) -> PlacedUse:
        """Return a use with hands on the table in front, for ON_TABLES of the places with a table and free arms."""
        rng = np.random.default_rng([placed.item, placed.use.place])  # equal for all uses of a place
        if rng.random() > ON_TABLES:
            return placed
        made = with_hands_on(placed.use, placed.root, placed.rotations, tops, rng)
        if made is None:
            return placed
        laid = replace(placed, use=made[0], rotations=made[1])
        deep = (self.depth(laid.root, laid.rotations, laid.item) > DEEP).any()
        return placed if deep else laid

    def _open_part(self, placed: PlacedUse) -> PlacedUse | None:
        """Return the part of a use that is free of other objects and whose ends are reachable, or None.

        The motion towards the seat and away from it may be cut off, since walks have their own routes.
        """
        use, count = placed.use, len(placed.root)
        blocked = STEP * np.flatnonzero(self.depth(placed.root, placed.rotations, placed.item) > DEEP)
        before = use.down - CLOSE if use.down >= 0 else 0
        after = use.up_end + CLOSE // 2 if use.up_end >= 0 else count
        if ((blocked >= before) & (blocked <= after)).any():
            return None
        start = int(blocked[blocked < before].max(initial=-STEP)) + STEP
        stop = int(blocked[blocked > after].min(initial=count))
        part = placed if (start, stop) == (0, count) else placed.cut(start, stop)
        ends = [0] if use.down >= 0 else []
        ends += [-1] if use.up_end >= 0 else []
        return part if all(self.reachable(part.flat[k, :2]) for k in ends) else None

    def hard(self, number: int) -> Obstacles | None:
        """Return a piece of furniture as obstacles in its own frame; None for soft ones and for no piece."""
        item = self._items.get(self.room.names[number]) if number >= 0 else None
        return item.obstacles if item is not None and self.room.categories[number] not in SOFT else None

    def to_piece(self, number: int, root: np.ndarray, rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return root (T, 3) and rotations (T, 22, 4) in the frame of a piece."""
        x, _, z, yaw = self.room.places[number]
        return turned(root - np.array([x, 0.0, z]), rotations, -yaw, np.zeros(3))

    def reachable(self, place: np.ndarray, within: float = 0.35) -> bool:
        """Return whether walkable ground of the main island is within some metres of a position (2,)."""
        return float(np.linalg.norm(self.free[:, [0, 2]] - place, axis=-1).min(initial=np.inf)) < within

    def depth(self, root: np.ndarray, rotations: np.ndarray, without: int | None = None) -> np.ndarray:
        """Return the depth (K,), metres, of surfaces in the flesh in every STEP-th frame, ``without`` one piece."""
        points, radii = bone_points(root[::STEP], rotations[::STEP])
        tree = self.surface[0] if without is None else self._without(without)
        gap = tree.query(points.reshape(-1, 3), distance_upper_bound=FAR)[0].reshape(points.shape[:2])
        return np.maximum(radii - gap, 0).max(1)

    @cached_property
    def solids(self) -> Obstacles:
        """Walls and all objects that are not for sitting or lying."""
        room = self.room
        seats = np.isin(room.objects, room.seats) | np.isin(room.classes, [CLASS["floor"], CLASS["ceiling"]])
        return Obstacles(room.triangles[~seats])

    @cached_property
    def hard_things(self) -> Obstacles:
        """Walls and all hard objects."""
        room = self.room
        soft = [k for k, category in enumerate(room.categories) if category in SOFT]
        shell = np.isin(room.classes, [CLASS["floor"], CLASS["ceiling"]])
        return Obstacles(room.triangles[~np.isin(room.objects, soft) & ~shell])

    def depth_beside(
        self, root: np.ndarray, rotations: np.ndarray, using: np.ndarray, frames: np.ndarray,
        rest: np.ndarray | None = None, solids: bool = True,
    ) -> np.ndarray:  # fmt: skip
        """Return the depth (K,), metres, of some frames, without the piece in use (T,) in each; negative outside.

        rest: (J, 3) joints of the body, None for the default human's. solids: whether bones in the middle of solid
        objects are detected as well.
        """
        out = np.zeros(len(frames))
        at = using[frames]
        for number in np.unique(at):
            rows = np.flatnonzero(at == number)
            points, radii = bone_points(root[frames[rows]], rotations[frames[rows]], rest)
            tree = self.surface[0] if number < 0 else self._without(int(number))
            gap = tree.query(points.reshape(-1, 3), distance_upper_bound=FAR)[0].reshape(points.shape[:2])
            depth = radii - gap
            if solids:
                # A bone in the middle of an object is far from its surfaces.
                outside = bone_points(self.outside[0], self.outside[1], rest)[0]
                inside = self.solids.depth(np.concatenate([outside, points]))[0][1:]
                depth = np.maximum(depth, np.where(inside > 0, inside + radii, 0))
            out[rows] = depth.max(1)
        return out

    @cached_property
    def outside(self) -> tuple[np.ndarray, np.ndarray]:
        """Root (1, 3) and rotations (1, 22, 4) of a body at the place of largest clearance, outside of all objects."""
        place = self.free[int(self.clearance.argmax())]
        rotations = np.zeros((1, skeleton.BODY_COUNT, 4))
        rotations[..., 0] = 1
        return np.array([[place[0], 0.95, place[2]]]), rotations

    def route(self, start: np.ndarray, goal: np.ndarray) -> np.ndarray | None:
        """Return the corners (N, 2), metres, of the route between two positions (2,), or None."""
        lift = lambda p: np.array([p[0], 0.0, p[1]])
        try:
            found = path.plan(self.mesh, lift(start), lift(goal), comfort=0.12)
        except PathError:
            return None
        corners = found.waypoints[:, [0, 2]]
        # Keep the requested ends, which may be off the mesh.
        if np.linalg.norm(corners[0] - start) > 0.02:
            corners = np.concatenate([start[None], corners])
        if np.linalg.norm(corners[-1] - goal) > 0.02:
            corners = np.concatenate([corners, goal[None]])
        return corners

    def place(self, rng: np.random.Generator, least: float = 0.3) -> np.ndarray:
        """Return a random position (2,) to stand with clearance around it, metres."""
        roomy = np.flatnonzero(self.clearance >= min(least, np.quantile(self.clearance, 0.6)))
        return self.free[rng.choice(roomy)][[0, 2]]


def _tree(points: np.ndarray) -> cKDTree:
    """Return a k-d tree optimised for construction time."""
    return cKDTree(points, balanced_tree=False, compact_nodes=False)
