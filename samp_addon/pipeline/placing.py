"""Where a body would be at a point that an artist aims at: on which furniture, how, and why not. Without Blender.

The scene is read once; a question is answered in a few hundredths of a second, however large the scene is. Network
frame, metres, radians.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import PathError, SampError
from ..frames import direction_yaw, yaw_direction
from ..motion import Goal
from ..scene.furniture import parts as furniture_parts
from ..scene.furniture import room
from ..scene.furniture.belongings import belongings
from ..scene.furniture.floor import floor_beside
from ..scene.geometry import SceneGeometry, extent
from ..scene.navmesh import navmesh as navigation
from ..scene.navmesh import path as paths
from ..scene.rays import Hit, Rays
from ..scene.seats import nearby, postures, seats
from ..scene.seats.support import SupportMap
from . import beside_others
from .cast.role import Other

AROUND = 1.0
"""Metres around a piece in which other things are in the way of a body."""

FLAT = 0.12
"""Metres over the floor up to which a surface is floor: rugs, thresholds."""

BESIDE = 0.3
"""Metres from the point on a floor to where a body has room to stand."""

BODY = np.array([0.35, 0.9, 0.35])
"""Half of the box, metres, in which something is in the way of a body at a point."""

SITTING = 0.15
"""Score that sitting is worth over lying where both are possible, as on a bench."""

APART = 0.5
"""Metres between two bodies that stand."""

TargetOf = Callable[[str], tuple[str, tuple[str, ...]] | None]
"""The target that an object belongs to, by name, and the names of its objects; None for floors, walls and the like."""

PosturesAt = Callable[[Goal, np.ndarray], Sequence[str]]
"""Postures in which a body can rest at a goal among triangles (F, 3, 3)."""


@dataclass(frozen=True)
class Spot:
    """Where a body would be.

    action: "sit", "lie" or "walk". target: name of the furniture, empty for a floor. goal: of the pelvis; on a floor,
    the place to stand. choices: how many other ways there are at this point, this one included. reason: why nobody can
    be there, a sentence; empty where a body fits. parts: names of the target's objects. posture: of the rest, by one of
    vocabulary.POSTURES; empty for any.
    """

    action: str
    target: str
    goal: Goal
    choices: int = 1
    reason: str = ""
    parts: tuple[str, ...] = ()
    posture: str = ""

    @property
    def fits(self) -> bool:
        """Whether a body fits there."""
        return not self.reason

    @property
    def yaw(self) -> float:
        """The facing, radians."""
        return float(direction_yaw(self.goal.direction))

    @property
    def point(self) -> np.ndarray:
        """The point (3,) of the surface that carries the body."""
        return np.asarray(self.goal.position) if self.action == "walk" else nearby.on_surface(self.goal)


@dataclass(frozen=True)
class _Piece:
    target: str
    parts: tuple[str, ...]
    triangles: np.ndarray
    around: np.ndarray
    floor: float | None
    grid: SupportMap


class Placer:
    """Answers for one scene. mesh: the walkable ground, see `survey`; None until then: ways are not checked."""

    def __init__(
        self,
        scene: SceneGeometry,
        target_of: TargetOf,
        others: Sequence[Other] = (),
        start: np.ndarray | None = None,
        postures_at: PosturesAt = lambda goal, triangles: (),
    ) -> None:
        self.scene, self.target_of, self.others, self.start = scene, target_of, tuple(others), start
        self.postures_at = postures_at
        self.rays = Rays(scene)
        self.mesh: navigation.NavMesh | None = None
        self._pieces: dict[object, _Piece | None] = {}
        self._rooms: dict[tuple[str, ...], list[np.ndarray] | None] = {}

    def survey(self) -> None:
        """Find the walkable ground, which takes seconds in a large scene; may run in a thread."""
        cover = None if self.start is None else self.start[None]
        try:
            self.mesh = navigation.build(self.scene.triangles, cover=cover)
        except SampError:
            return  # nothing can be walked on: the job itself says why
        self._pieces = {}  # their floors are known now

    def under(
        self, origin: np.ndarray, direction: np.ndarray, choice: int = 0, yaw: float | None = None
    ) -> Spot | None:
        """Return the spot at the first surface on a ray, or None; see `at`."""
        hit = self.rays.first(origin, direction)
        return None if hit is None else self.at(hit, choice, yaw)

    def at(self, hit: Hit, choice: int = 0, yaw: float | None = None) -> Spot:
        """Return the spot at a point of an object. choice: number of the way to be there, from the best one on, any
        integer. yaw: the wanted facing."""
        found = self.target_of(hit.name)
        if found is None:
            return self._on_floor(hit, yaw)
        piece = self._piece(*found, hit.point)
        if piece is None:
            return self._on_floor(hit, yaw)
        height = hit.point[1] - piece.grid.floor
        if height < FLAT and hit.normal[1] > 0.7:
            return self._on_floor(hit, yaw)
        return self._with_way(self._on_piece(piece, hit.point, choice, yaw))

    def shown(self, spot: Spot) -> tuple[np.ndarray | None, float]:
        """Return the triangles (F, 3, 3) of a spot's furniture, or None on a floor, and the height of its floor."""
        if not spot.parts:
            return None, float(spot.point[1])
        piece = self._piece(spot.target, spot.parts, spot.point)
        return (None, 0.0) if piece is None else (piece.triangles, float(piece.grid.floor))

    def _piece(self, target: str, parts: tuple[str, ...], point: np.ndarray) -> _Piece | None:
        """Return the piece of furniture that objects are, or that a point of a whole room belongs to; None for what is
        no furniture."""
        if parts not in self._rooms:
            self._rooms[parts] = self._pieces_of_room(parts)
        found = self._rooms[parts]
        if found is None:
            if parts not in self._pieces:
                mine = self.scene.is_one_of((*parts, *belongings(self.scene, parts)))
                self._pieces[parts] = self._read(target, parts, mine)
            return self._pieces[parts]
        if not found or self._is_ground(point):
            return None
        chosen = room.nearest(self.scene.triangles, found, point)
        key = parts, int(chosen[0])
        if key not in self._pieces:
            mine = np.zeros(len(self.scene), dtype=bool)
            mine[chosen] = True
            self._pieces[key] = self._read(target, parts, mine)
        return self._pieces[key]

    def _pieces_of_room(self, parts: tuple[str, ...]) -> list[np.ndarray] | None:
        """Return the triangles of each piece of a whole room; None for what is a piece itself."""
        mine = np.flatnonzero(self.scene.is_one_of(parts))
        if not len(mine):
            return []
        own = self.scene.triangles[mine], self.scene.object_ids[mine]
        if not furniture_parts.is_room(*own):
            return None
        return [mine[piece] for piece in furniture_parts.pieces(*own)[0]]

    def _read(self, target: str, parts: tuple[str, ...], mine: np.ndarray) -> _Piece | None:
        triangles = self.scene.triangles[mine]
        low, high = extent(triangles)
        near = self.rays.in_box(low - AROUND, high + AROUND)
        around = self.scene.triangles[near[~mine[near]]]
        floor = None if self.mesh is None else floor_beside(self.mesh, triangles)
        try:
            grid = seats.support_map(triangles, floor, around)
        except SampError:
            return None
        return _Piece(target, parts, triangles, around, floor, grid)

    def _is_ground(self, point: np.ndarray) -> bool:
        """Whether a point is on walkable ground."""
        if self.mesh is None:
            return False
        number = int(self.mesh.ground.at(point))
        return number >= 0 and abs(float(self.mesh.ground.points(np.array(number))[1]) - point[1]) < FLAT

    def _on_piece(self, piece: _Piece, point: np.ndarray, choice: int, yaw: float | None) -> Spot:
        found = self._places(piece.grid, point, None)
        free = [seat.goal for seat in found if beside_others.free_goals([seat.goal], self.others)]
        ways = [(goal, "") for goal in free]
        for best in {goal.action: goal for goal in reversed(free)}.values():  # the first one of each action
            ways += [(best, name) for name in self._postures(piece, best)]
        if ways:
            goal, posture = ways[choice % len(ways)]
            common = {"choices": len(ways), "parts": piece.parts, "posture": posture}
            if yaw is None:
                return Spot(goal.action, piece.target, goal, **common)
            for seat in nearby.places(piece.grid, point, goal.action, yaw):
                if beside_others.free_goals([seat.goal], self.others):
                    return Spot(goal.action, piece.target, seat.goal, **common)
            reason = f"There is no room on '{piece.target}' to {goal.action} facing this way."
            turned = replace(goal, direction=yaw_direction(yaw))
            return Spot(goal.action, piece.target, turned, reason=reason, **common)
        goal = found[0].goal if found else nearby.goal_at(point, yaw or 0.0, "sit")
        return Spot(goal.action, piece.target, goal, 1, self._why_not(piece, point, found), piece.parts)

    def _postures(self, piece: _Piece, goal: Goal) -> Sequence[str]:
        return self.postures_at(goal, np.concatenate([piece.triangles, piece.around]))

    @staticmethod
    def _places(grid: SupportMap, point: np.ndarray, yaw: float | None) -> list[seats.Seat]:
        """Return the places near a point to sit and to lie, best first."""
        both = [*nearby.places(grid, point, "sit", yaw), *nearby.places(grid, point, "lie", yaw)]
        return sorted(both, key=lambda seat: -seat.score - (SITTING if seat.goal.action == "sit" else 0))

    def _why_not(self, piece: _Piece, point: np.ndarray, found: Sequence[seats.Seat]) -> str:
        """Return why no body fits at a point of a piece. found: places that others occupy."""
        if found:
            who = beside_others.occupants([seat.goal for seat in found], self.others)
            return f"{' and '.join(repr(name) for name in who)} is already on '{piece.target}'."
        alone = seats.support_map(piece.triangles, piece.floor)
        if self._places(alone, point, None):
            return f"{self._in_the_way(piece, point)} is in the way of a body on '{piece.target}'."
        height, (low, high) = point[1] - piece.grid.floor, postures.SIT_HEIGHTS
        if not low <= height <= high:
            return (
                f"'{piece.target}' is {height:.2f} m high here; seats and beds are {low:.2f} to {high:.2f} m."
            )
        return f"There is no flat place here on '{piece.target}' that is large enough for a body."

    def _in_the_way(self, piece: _Piece, point: np.ndarray) -> str:
        """Return the name of the object nearest to a body at a point, other than the piece's own."""
        near = self.rays.in_box(point - BODY, point + BODY)
        near = near[~self.scene.is_one_of(piece.parts)[near]]
        corners = self.scene.triangles[near]
        over = corners[..., 1].max(1) > point[1] + FLAT
        near, corners = near[over], corners[over]
        if not len(near):
            return "Something"
        away = np.linalg.norm(np.clip(point, corners.min(1), corners.max(1)) - point, axis=-1)
        return f"'{self.scene.names[self.scene.object_ids[near[away.argmin()]]]}'"

    def _with_way(self, spot: Spot) -> Spot:
        """Return a spot, with the reason where no way leads to it."""
        if not spot.fits or self.mesh is None:
            return spot
        start = self.start
        if start is None:
            start = self.mesh.ground.points(np.array(self.mesh.nearest(spot.point)))
        try:
            paths.ends(self.mesh, start, spot.goal)
        except PathError as error:
            reason = str(error).split(";")[0].rstrip(".") + "."
            return replace(spot, reason=reason)
        return spot

    def _on_floor(self, hit: Hit, yaw: float | None) -> Spot:
        facing = np.zeros(3) if yaw is None else yaw_direction(yaw)
        spot = Spot("walk", "", Goal(hit.point, facing, "walk"))
        if hit.normal[1] < 0.7:
            return replace(spot, reason=f"'{hit.name}' is no floor, seat or bed.")
        for other in self.others:
            if np.linalg.norm((other.pelvis - hit.point)[[0, 2]]) < APART:
                return replace(spot, reason=f"'{other.name}' is already there.")
        if self.mesh is None:
            return spot
        island = None
        if self.start is not None:
            island = int(self.mesh.island_of(np.array(self.mesh.nearest(self.start))))
        place = self.mesh.ground.points(np.array(self.mesh.nearest(hit.point, island)))
        if np.linalg.norm(place - hit.point) <= BESIDE:
            return replace(spot, goal=replace(spot.goal, position=place))
        anywhere = self.mesh.ground.points(np.array(self.mesh.nearest(hit.point)))
        room_here = np.linalg.norm(anywhere - hit.point) <= BESIDE
        return replace(
            spot, reason="No way leads here." if room_here else "There is no room to stand or walk here."
        )
