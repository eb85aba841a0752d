"""The whole chain without Blender: from a scene's triangles to takes (SAMP, figure 2). Network frame, metres.

target and action -> goal (GoalNet) -> path (navmesh, A*) -> motion (MotionNet). It may run in a thread of its
own: nothing here knows bpy, and what ``progress`` raises stops it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import dependencies
from ..errors import SampError
from ..evaluation import metrics
from ..frames import direction_yaw, yaw_direction
from ..methods.samp.request import Request
from ..methods.take import Clock, Failure, Situation, Take, Tools
from ..motion import Goal, Motion
from ..progress import Progress, StageProgress
from ..scene.distance import solids
from ..scene.geometry import extent
from ..scene.navmesh import navmesh as navigation
from ..scene.navmesh import path as paths
from ..scene.seats.seats import infer_front_yaw
from .job import SEATED, Job

START_DISTANCE = (1.5, 3.5)
"""Metres from the goal at which a free start is looked for."""

SURROUNDINGS = 1.0
"""Metres around a target in which other things may be in a seated body's way."""

STAND_OFF = 0.5
"""Metres between an object and who stands in front of it."""

MOST_AT_ONCE = 32
"""Takes in one batch."""

ATTEMPTS = 3
"""A take that fails is tried again with other noise and, another place on the target."""

MOST_STOOP = 0.09
"""Metres that the pelvis may end lower than in standing on straight legs."""

_NEXT_ATTEMPT = 1_000_003  # added to the seed: far from the seeds that an artist counts through


def networks() -> Tools:
    """The trained networks; imports torch."""
    dependencies.load_torch()
    from ..methods.samp import goals
    from ..methods.samp.rollout import generator

    return Tools(goals.sample_goals, generator.generate)


def standing_height() -> float:
    """Metres from the floor to the pelvis joint of the default human on straight legs."""
    from ..body import human

    return -human.load().floor


def synthesise(
    job: Job,
    situation: Situation,
    progress: Progress = lambda stage, share: None,
    tools: Tools | None = None,
    after: Mapping[int, Take] | None = None,
) -> tuple[list[Take], list[Failure]]:
    """The job's takes, and why others failed. Raises SampError where no take can be made at all.

    All takes are rolled out as one batch; those that fail are tried again together. after: by seed, the takes that
    these go on from; then only their seeds are made, and the situation's start counts for nothing.
    """
    clock = Clock()
    progress("Loading", 0.0)
    with clock.stage("load"):
        tools = tools or networks()
    progress("Finding the floor", 0.0)
    with clock.stage("navmesh"):
        chain = _Chain(job, situation, tools, _navmesh(situation, after or {}), after or {})
    best: dict[int, Take] = {}
    reasons: dict[int, str] = {}
    seeds = list(job.seeds if after is None else after)
    waiting = seeds
    for attempt in range(ATTEMPTS):
        for start in range(0, len(waiting), MOST_AT_ONCE):
            some = waiting[start : start + MOST_AT_ONCE]
            for seed, result in zip(some, chain.attempt(some, attempt, progress, clock), strict=True):
                if isinstance(result, SampError):
                    reasons.setdefault(seed, str(result))
                elif seed not in best or _error(result) < _error(best[seed]):
                    best[seed] = result
        waiting = [seed for seed in waiting if seed not in best or not _arrived(best[seed])]
        if not waiting:
            break
    progress("Done", 1.0)
    takes = [replace(best[seed], seconds=clock.seconds) for seed in seeds if seed in best]
    return takes, [Failure(seed, reasons[seed]) for seed in seeds if seed not in best]


def _arrived(take: Take) -> bool:
    """Whether a take is on its goal, and who walked there stands upright: some captured people stoop at the end."""
    stooping = take.goal.action not in SEATED and take.motion.root[-1, 1] < take.goal.position[1] - MOST_STOOP
    return metrics.success(take.motion, take.goal) and not stooping


def end_of(take: Take) -> tuple[np.ndarray, float]:
    """Where a way can begin after a take, floor (3,) and yaw: beside the seat, or where the character stands."""
    yaw = float(direction_yaw(metrics.heading(take.motion)[-1]))
    return (take.waypoints[-1] if take.goal.action in SEATED else _below_pelvis(take)), yaw


def _below_pelvis(take: Take) -> np.ndarray:
    """The floor (3,) under the pelvis at a take's end, at the height of the floor that it came on."""
    place = take.motion.root[-1].copy()
    place[1] = take.waypoints[-1][1]
    return place


def _error(take: Take) -> float:
    return metrics.position_error(take.motion, take.goal)


def _navmesh(situation: Situation, after: Mapping[int, Take]) -> navigation.NavMesh:
    places = [goal.position for goal in situation.goals] + [take.waypoints[-1] for take in after.values()]
    for place in (situation.start, situation.destination):
        if place is not None:
            places.append(place[0])
    if situation.target is not None:
        places += extent(situation.target)
    return navigation.build(situation.scene.triangles, cover=np.array(places).reshape(-1, 3))


@dataclass(frozen=True)
class _Chain:
    """What all takes of a job share."""

    job: Job
    situation: Situation
    tools: Tools
    mesh: navigation.NavMesh
    after: Mapping[int, Take]

    def attempt(
        self, seeds: Sequence[int], number: int, progress: Progress, clock: Clock
    ) -> list[Take | SampError]:
        """One attempt for each of these seeds, with noise of its own; errors stand in their take's place."""
        requests, results = {}, {}
        for seed in seeds:
            progress("Choosing a place", 0.0)
            try:
                requests[seed] = self._request(seed, (seed + number * _NEXT_ATTEMPT) % 2**31, clock)
            except SampError as error:
                results[seed] = error
        with clock.stage("rollout"):
            motions = self.tools.generate(list(requests.values()), StageProgress(progress, "Moving"))
        for (seed, request), motion in zip(requests.items(), motions, strict=True):
            goal = request.goal
            if self.job.action not in SEATED:
                goal = replace(goal, position=goal.position + [0.0, standing_height(), 0.0])
            if isinstance(motion, SampError):
                results[seed] = motion
                continue
            paced = _paced(motion, self.job.speed)
            ground = self.mesh.laid_ground
            results[seed] = Take(seed, paced, goal, request.waypoints, {}, number + 1, laid_ground=ground)
        return [results[seed] for seed in seeds]

    def _request(self, seed: int, noise: int, clock: Clock) -> Request:
        """A place on the target and a way there. Raises SampError."""
        before = self.after.get(seed)
        rng = np.random.default_rng(noise)
        seated = self.job.action in SEATED
        with clock.stage("goal"):
            goal = self._seat(noise) if seated else self._standing_goal(rng, before)
        with clock.stage("path"):
            start, yaw = self._start(goal.position, rng) if before is None else end_of(before)
            waypoints = self._way(start, goal)
            if not seated:
                # Who is sent into a table stands beside it.
                goal = replace(goal, position=waypoints[-1])
            goal = _facing(goal, waypoints, yaw)
        return Request(
            start_position=waypoints[0] if before is None else _below_pelvis(before),
            start_yaw=yaw,
            action=self.job.action,
            goal=goal,
            waypoints=waypoints,
            object_triangles=self.situation.target if seated else None,
            object_yaw=self._front if seated else 0.0,
            seed=noise,
            hold_seconds=self.job.hold * self.job.speed,
            style=self.job.style,
            after=None if before is None else before.motion,
        )

    def _way(self, start: np.ndarray, goal: Goal) -> np.ndarray:
        """Way-points (N, 3) from the start past the artist's places to the goal. Raises SampError."""
        legs = []
        for place in self.situation.via:
            legs.append(paths.plan(self.mesh, start, place).waypoints)
            start = legs[-1][-1]
        seated = self.job.action in SEATED
        last = (
            paths.plan_to_goal(self.mesh, start, goal)
            if seated
            else paths.plan(self.mesh, start, goal.position)
        )
        # Each leg begins where the one before it ended.
        return np.concatenate([*(leg[:-1] for leg in legs), last.waypoints])

    @cached_property
    def _front(self) -> float:
        return infer_front_yaw(self.situation.target)

    def _start(self, goal: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
        """Where the character starts, on the floor, and its yaw."""
        if self.situation.start is None:
            return navigation.free_place(self.mesh, goal, START_DISTANCE, rng)
        place, yaw = self.situation.start
        return place, yaw

    def _seat(self, noise: int) -> Goal:
        """Where on the target the pelvis shall end."""
        job, chosen = self.job, [goal for goal in self.situation.goals if goal.action == self.job.action]
        found = chosen[noise % len(chosen) :] if chosen else []
        found = found or self._sampled(noise)
        if not found:
            raise SampError(f"There is no place to {job.action} on '{job.target}'; choose another object.")
        return found[0]

    def _sampled(self, noise: int) -> Sequence[Goal]:
        target = self.situation.target
        return self.tools.sample_goals(target, self.job.action, 1, noise, self._surroundings)

    @cached_property
    def _surroundings(self) -> np.ndarray:
        """Triangles (F, 3, 3) of what else stands within reach of the target."""
        target, others = self.situation.target, self.situation.scene.without(self.situation.parts)
        low, high = extent(target)
        return solids.overlapping_box(others.triangles, low - SURROUNDINGS, high + SURROUNDINGS)

    def _standing_goal(self, rng: np.random.Generator, before: Take | None) -> Goal:
        """A place on the floor; its direction is zero where none is asked for."""
        situation, action = self.situation, self.job.action
        if situation.destination is not None:
            position, yaw = situation.destination
            return Goal(position, np.zeros(3) if yaw is None else yaw_direction(yaw), action)
        if situation.target is not None:
            return self._beside(situation.target)
        place, yaw = self._start(self.mesh.points.mean(0), rng) if before is None else end_of(before)
        return Goal(self.mesh.ground.points(np.array(self.mesh.nearest(place))), yaw_direction(yaw), action)

    def _beside(self, triangles: np.ndarray) -> Goal:
        """A place to stand in front of an object, facing it."""
        low, high = extent(triangles)
        middle = (low + high) / 2
        out = yaw_direction(self._front)
        reach = float(np.abs(out) @ (high - low)) / 2 + STAND_OFF
        wanted = np.array([middle[0], low[1], middle[2]]) + out * reach
        position = self.mesh.ground.points(np.array(self.mesh.nearest(wanted)))
        return Goal(position, _horizontal(middle - position), self.job.action)


def _paced(motion: Motion, speed: float) -> Motion:
    """The motion, faster or slower by a factor, at the same frame rate."""
    return motion if speed == 1 else replace(motion, fps=motion.fps * speed).resampled(motion.fps)


def _facing(goal: Goal, waypoints: np.ndarray, yaw: float) -> Goal:
    """The goal with a direction: its own, else the one in which its way ends."""
    if np.any(goal.direction):
        return goal
    steps = _horizontal(waypoints[-1] - waypoints[-2]) if len(waypoints) > 1 else np.zeros(3)
    return replace(goal, direction=steps if steps.any() else yaw_direction(yaw))


def _horizontal(vector: np.ndarray) -> np.ndarray:
    """The horizontal part (3,) at length 1; zero where there is none."""
    flat = vector * [1.0, 0.0, 1.0]
    length = np.linalg.norm(flat)
    return flat / length if length > 1e-6 else np.zeros(3)
