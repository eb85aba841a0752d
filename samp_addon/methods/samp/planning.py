"""What MotionNet is asked for: a goal on the target, and a path to it (SAMP, sections 3.2 and 3.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ...body import human
from ...clock import Clock
from ...errors import NoPlaceError, PathError, SampError
from ...frames import yaw_direction
from ...motion import Goal, Motion
from ...scene import flights
from ...scene.distance import solids
from ...scene.distance.signed_distance import LARGE
from ...scene.furniture.floor import floor_beside
from ...scene.geometry import extent
from ...scene.navmesh import navmesh as navigation
from ...scene.navmesh import path as paths
from ...scene.navmesh.lattice import clip_to_box
from ...scene.seats.seats import infer_front_yaw
from ...vocabulary import SEATED
from .. import getting_up
from ..appending import append
from ..method import Draw
from ..scene_view import SceneView
from ..step import Step
from ..take import Take
from . import posture_places, postures, refusals
from .request import Request

START_DISTANCE = (1.5, 3.5)
"""Metres from the goal at which a free start is looked for."""

SURROUNDINGS = 1.0
"""Metres around a target in which other things can obstruct a seated body."""

MOVED = 0.1
"""Metres beside the artist's place from which that is worth a remark."""

FRONT, CRAMPED = 0.5, 0.15
"""Metres in front of a seated pelvis where a body stands before it sits down, and from there to the nearest free floor
beyond which a seat is cramped."""

BESIDE_PATH = 0.3
"""Metres beside a path through a narrow gap within which the body is kept."""

STAND_OFF = 0.5
"""Metres between an object and a character that stands in front of it."""


def standing_height() -> float:
    """Return the metres from the floor to the pelvis joint of the default human on straight legs."""
    return -human.load().floor


@dataclass(frozen=True)
class Planner:
    """Requests for the takes of one step. sample_goals: GoalNet, see networks.py."""

    step: Step
    scene: SceneView
    sample_goals: Callable[..., Sequence[Goal]]
    mesh: navigation.NavMesh

    def request(self, draw: Draw, clock: Clock) -> Request:
        """Return a place on the target and a path there. Raise SampError where there is none."""
        before = self.scene.after.get(draw.seed)
        lead = None if before is None else getting_up.from_bed(before, standing_height())
        if lead is not None:
            before = replace(before, motion=append(before.motion, lead), goal=None)
        rng = np.random.default_rng(draw.noise)
        seated = self.step.action in SEATED
        with clock.stage("goal"):
            goal = self._seat(draw.noise) if seated else self._standing_goal(rng, before)
        with clock.stage("path"):
            start, yaw = self._start(goal.position, rng) if before is None else before.exit
            waypoints, narrow = self._path(start, goal)
            remarks = ((self._narrow,) if narrow else ()) + self._remarks(waypoints)
            places = partial(self._posture_places, goal) if seated else tuple
            if not seated:
                # A destination inside an obstacle is snapped to the nearest walkable point.
                goal = replace(goal, position=waypoints[-1])
            goal = _with_direction(goal, waypoints, yaw)
        return Request(
            start_position=waypoints[0] if before is None else before.below_end,
            start_yaw=yaw,
            action=self.step.action,
            goal=goal,
            waypoints=waypoints,
            object_triangles=self.scene.target if seated else None,
            object_front=lambda: self._front,
            seed=draw.noise,
            hold_seconds=self.step.hold * self.step.speed,
            style=self.step.style,
            after=None if before is None else before.motion,
            lead=lead,
            remarks=remarks + self._without_place(places),
            ground=self.mesh.heights_at,
            free=self._kept_clear(waypoints, goal) if narrow or self._cramped(goal) else None,
            posture=self._posture,
            posture_places=places,
            table=lambda: posture_places.table(self._around, goal),
            flights=flights.find(waypoints, self.scene.geometry.triangles),
        )

    def take(self, seed: int, request: Request, motion: Motion) -> Take:
        """Return the take of a request's motion; the goal of a walk is raised to the standing pelvis."""
        goal = request.goal
        if self.step.action not in SEATED:
            goal = replace(goal, position=goal.position + [0.0, standing_height(), 0.0])
        if request.lead is not None:
            motion = append(request.lead, motion)
        return Take(
            seed,
            motion,
            goal=goal,
            waypoints=request.waypoints,
            laid_ground=self.mesh.laid_ground,
            remarks=request.remarks,
        )

    @cached_property
    def _posture(self) -> tuple[str, ...]:
        """Postures that the artist asks for."""
        return postures.of_action(postures.parse(self.step.settings.get("posture")), self.step.action)

    def _posture_places(self, goal: Goal) -> tuple[str, ...]:
        return posture_places.around(self._around, goal)

    def _without_place(self, places: Callable[[], tuple[str, ...]]) -> tuple[str, ...]:
        """Return a sentence for each posture that the artist asks for and for which there is no place."""
        needing = [name for name in self._posture if name in postures.NEEDS_PLACE]
        missing = sorted(set(needing) - set(places()), key=needing.index) if needing else []
        return tuple(f"There is nothing at '{self.step.target}' for {name}." for name in missing)

    def _remarks(self, waypoints: np.ndarray) -> tuple[str, ...]:
        """Return a sentence for each of the artist's places that the path (N, 3) does not reach."""
        found = []
        for number, place in enumerate(self.scene.via, start=1):
            missed = np.linalg.norm((waypoints - place)[:, [0, 2]], axis=-1).min()
            if missed > MOVED:
                found.append(
                    f"Way-point {number} is not on free floor: the path passes it by {missed:.1f} m."
                )
        if self.scene.destination is not None and self.step.action not in SEATED:
            missed = np.linalg.norm((waypoints[-1] - self.scene.destination[0])[[0, 2]])
            if missed > MOVED:
                found.append(
                    f"The destination is not on free floor: the {self.step.action} ends {missed:.1f} m beside it."
                )
        return tuple(found)

    def _path(self, start: np.ndarray, goal: Goal) -> tuple[np.ndarray, bool]:
        """Return way-points (N, 3) from the start past the artist's places to the goal, and whether they lead through
        a narrow gap. Raise SampError where there is no way."""
        legs, narrow = [], False
        for place in self.scene.via:
            legs.append(paths.plan(self.mesh, start, place).waypoints)
            start = legs[-1][-1]
        if self.step.action in SEATED:
            last, narrow = self._to_seat(start, goal)
        else:
            last = paths.plan(self.mesh, start, goal.position)
        # Each leg begins where the one before it ended.
        return np.concatenate([*(leg[:-1] for leg in legs), last.waypoints]), narrow

    def _to_seat(self, start: np.ndarray, goal: Goal) -> tuple[paths.Path, bool]:
        """Return the path to a place beside the goal, and whether it leads through a gap, where there is no other.

        Raises SampError that names what is in the way.
        """
        try:
            return paths.plan_to_goal(self.mesh, start, goal), False
        except PathError as error:
            try:
                return paths.plan_to_goal(self.scene.narrow_navmesh, start, goal), True
            except PathError:
                pass
            known = self.scene.explained
            if str(error) not in known:
                known[str(error)] = refusals.no_way(self.step, self.scene, start, goal, error)
            raise known[str(error)] from error

    def _cramped(self, goal: Goal) -> bool:
        """Return whether there is no room to stand in front of a seat."""
        if goal.action != "sit":
            return False
        front = goal.position + FRONT * np.asarray(goal.direction)
        nearest = self.mesh.ground.points(np.array(self.mesh.nearest(front)))
        return float(np.linalg.norm((nearest - front)[[0, 2]])) > CRAMPED

    def _kept_clear(self, waypoints: np.ndarray, goal: Goal) -> Callable[[np.ndarray], np.ndarray]:
        """Return the function that moves points (N, 3) to where a body has room along a path (N, 3) to a goal."""
        stand = goal.position + BESIDE_PATH * np.asarray(goal.direction)
        room, corners = self.scene.room_to_sit_down, [*waypoints, stand, goal.position]
        legs = zip(corners[:-1], corners[1:], strict=True)
        line = np.concatenate([np.linspace(a, b, 2 + int(np.linalg.norm(b - a) / 0.05)) for a, b in legs])
        return lambda points: room.nearest_places(points, line, BESIDE_PATH)

    @property
    def _narrow(self) -> str:
        way = f"The way to '{self.step.target}' is narrower than {200 * self.mesh.agent.radius:.0f} cm"
        return f"{way}: the body brushes what stands beside it."

    @cached_property
    def _front(self) -> float:
        return infer_front_yaw(self.scene.target)

    def _start(self, goal: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
        """Return where the character starts, on the floor, and its yaw."""
        if self.scene.start is None:
            return navigation.free_place(self.mesh, goal, START_DISTANCE, rng)
        place, yaw = self.scene.start
        return place, yaw

    def _seat(self, noise: int) -> Goal:
        """Return where on the target the pelvis ends: the artist's goals by turns, else GoalNet's."""
        chosen = [goal for goal in self.scene.goals if goal.action == self.step.action]
        found = chosen[noise % len(chosen) :] if chosen else []
        suited = partial(posture_places.suited, self._around, posture=self._posture)
        found = found or [suited(goal) for goal in self._sampled(noise)]
        if not found:
            raise self._no_place
        return found[0]

    def _sampled(self, noise: int) -> Sequence[Goal]:
        """Return GoalNet's goal, or none where the target has no place."""
        floor = () if self._floor is None else (self._floor,)
        try:
            return self.sample_goals(
                self.scene.target, self.step.action, 1, noise, self._surroundings, *floor
            )
        except NoPlaceError:
            return ()

    @property
    def _no_place(self) -> SampError:
        known, about = self.scene.explained, f"{self.step.action} {self.step.target}"
        if about not in known:
            known[about] = refusals.no_place(self.step, self.scene, self._floor, SURROUNDINGS)
        return known[about]

    @cached_property
    def _floor(self) -> float | None:
        """Height of the floor beside the target, metres; None where the target stands on it."""
        return floor_beside(self.mesh, self.scene.target)

    @cached_property
    def _around(self) -> np.ndarray:
        return np.concatenate([self.scene.target, self._surroundings])

    @cached_property
    def _surroundings(self) -> np.ndarray:
        """Triangles (F, 3, 3) of what else stands within reach of the target."""
        target, others = self.scene.target, self.scene.geometry.without(self.scene.parts)
        low, high = extent(target)
        low, high = low - SURROUNDINGS, high + SURROUNDINGS
        near = solids.overlapping_box(others.triangles, low, high)
        # Towers and hills are sampled too sparsely as wholes.
        return clip_to_box(near, low, high) if len(near) and np.ptp(near, axis=(0, 1)).max() > LARGE else near

    def _standing_goal(self, rng: np.random.Generator, before: Take | None) -> Goal:
        """Return a place on the floor; its direction is zero where none is asked for."""
        scene, action = self.scene, self.step.action
        if scene.destination is not None:
            position, yaw = scene.destination
            return Goal(position, np.zeros(3) if yaw is None else yaw_direction(yaw), action)
        if scene.target is not None:
            return self._in_front(scene.target)
        place, yaw = self._start(self.mesh.points.mean(0), rng) if before is None else before.exit
        return Goal(self.mesh.ground.points(np.array(self.mesh.nearest(place))), yaw_direction(yaw), action)

    def _in_front(self, triangles: np.ndarray) -> Goal:
        """Return a place to stand in front of an object, facing it."""
        low, high = extent(triangles)
        middle = (low + high) / 2
        out = yaw_direction(self._front)
        reach = float(np.abs(out) @ (high - low)) / 2 + STAND_OFF
        wanted = np.array([middle[0], low[1], middle[2]]) + out * reach
        position = self.mesh.ground.points(np.array(self.mesh.nearest(wanted)))
        return Goal(position, _horizontal(middle - position), self.step.action)


def _with_direction(goal: Goal, waypoints: np.ndarray, yaw: float) -> Goal:
    """Return the goal with a direction: its own, else the one in which its path ends."""
    if np.any(goal.direction):
        return goal
    steps = _horizontal(waypoints[-1] - waypoints[-2]) if len(waypoints) > 1 else np.zeros(3)
    return replace(goal, direction=steps if steps.any() else yaw_direction(yaw))


def _horizontal(vector: np.ndarray) -> np.ndarray:
    """Return the horizontal part (3,) at length 1; zero where there is none."""
    flat = vector * [1.0, 0.0, 1.0]
    length = np.linalg.norm(flat)
    return flat / length if length > 1e-6 else np.zeros(3)
