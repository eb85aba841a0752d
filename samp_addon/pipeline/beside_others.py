"""Takes of one character beside others that are in the scene already: their places and their ways are respected.

Places that they occupy in the end are not free, paths lead around them, and a take that would meet one of them begins
with a wait. All of this is that of a cast (cast/) in which only one member is directed. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..body import human
from ..body.human import Human
from ..errors import SampError
from ..evaluation.between_bodies import conflicts, over_time
from ..methods import registry
from ..methods.method import Method
from ..methods.scene_view import SceneView
from ..methods.step import Step
from ..methods.take import Take
from ..motion import Goal, Motion
from ..progress import Progress
from ..scene.navmesh.occupied import Disc
from ..vocabulary import SEATED
from . import other_body
from .cast import directing, idling, seating, timing, together
from .cast.assignment import BETWEEN_PIECES
from .cast.cast_take import OVERLAP, track
from .cast.role import Other
from .driver import Made, Remake, Work

AGAIN = 2
"""How often a take that meets others whenever it sets off is generated again, around where it met them."""

AROUND = {"sit": (0.0, 0.35, 0.20), "lie": (-0.75, 0.75, 0.22)}
"""Metres along the facing from the pelvis between which a resting body is, and its radius there."""

APART = {"sit": (0.0, 0.0), "lie": (-0.75, 0.75)}
"""Metres along the facing between which the pelvis of another body is at least BETWEEN_PIECES away."""

HEIGHTS = {"sit": (-0.22, 0.6), "lie": (-0.15, 0.35)}
"""Metres over the pelvis between which it does."""

MOST_POINTS = 0.02
"""Share of another body's points that may be in this room; skin that touches is no reason to sit elsewhere."""


def beside(work: Work, others: Sequence[Other]) -> Work:
    """Return the work with what it leaves to others. Raise SampError where they are on all places of a target.

    Only the first step knows where they are over time: the times at which later steps begin are not known.
    """
    if not others:
        return work
    pelvises = [other.pelvis for other in others]
    views = [
        _left(_with_free_goals(step, view, others), pelvises)
        for step, view in zip(work.job.steps, work.views, strict=True)
    ]
    views[0] = replace(views[0], others=[other.track for other in others])
    return replace(work, views=views, settle=_Settled(tuple(others), views[0], work.body or human.load()))


def free_goals(goals: Sequence[Goal], others: Sequence[Other]) -> list[Goal]:
    """Return the goals to sit or lie at which no other body is in the end."""
    return [goal for goal in goals if not any(_is_on(other, goal) for other in others)]


def occupants(goals: Sequence[Goal], others: Sequence[Other]) -> list[str]:
    """Return the names of the bodies that are at one of the goals in the end."""
    return [other.name for other in others if any(_is_on(other, goal) for goal in goals)]


def _is_on(other: Other, goal: Goal) -> bool:
    """Whether a body is, in the end, where one at the goal would be, or so near that their arms would meet."""
    ahead = np.asarray(goal.direction)
    away = other.pelvis - goal.position
    if abs(away[1]) < 0.5 and _from_line(away[None], ahead, *APART[goal.action])[0] < BETWEEN_PIECES:
        return True
    back, front, radius = AROUND[goal.action]
    low, high = HEIGHTS[goal.action]
    points = other.track.centres[-1] - goal.position
    level = (points[:, 1] > low) & (points[:, 1] < high)
    return float((level & (_from_line(points, ahead, back, front) < radius)).mean()) > MOST_POINTS


def _from_line(points: np.ndarray, ahead: np.ndarray, back: float, front: float) -> np.ndarray:
    """Return the horizontal distances (N,) of points to a piece of the line along a facing."""
    along = np.clip(points @ ahead, back, front)
    return np.linalg.norm((points - along[:, None] * ahead)[:, [0, 2]], axis=-1)


def _with_free_goals(step: Step, view: SceneView, others: Sequence[Other]) -> SceneView:
    """Return a view whose goals are the free places, where somebody else is near the target."""
    method = registry.METHODS.get(step.method)
    chooses = method is None or "goals" in method.needs
    if step.action not in SEATED or view.target is None or not chooses:
        return view
    near = [other for other in others if seating.near(view, other.pelvis[None])]
    if not near:
        return view
    goals = [place.goal for place in seating.places_on(0, view, step.action)]
    free = free_goals(goals, near)
    if goals and not free:
        who = " and ".join(f"'{name}'" for name in occupants(goals, near))
        verb = "are" if " and " in who else "is"
        raise SampError(
            f"{who} {verb} already on '{step.target}'; move that character away, or choose another target."
        )
    return replace(view, goals=free)


def _left(view: SceneView, pelvises: Sequence[np.ndarray]) -> SceneView:
    """Return a view whose paths lead around where others are in the end."""
    ends = (view.start, view.destination)
    own = [place[0] for place in ends if place is not None]
    return replace(view, occupied=seating.left_to_others([(p, seating.STANDING) for p in pelvises], own))


@dataclass(frozen=True)
class _Settled:
    """See driver.Settle: takes for which others leave no way are made through them, and all of them begin with a wait
    for as long as it takes to meet nobody. view: of the first step. body: that shows the takes."""

    others: tuple[Other, ...]
    view: SceneView
    body: Human

    def __call__(self, made: Made, remake: Remake, methods: Mapping[str, Method], progress: Progress) -> Made:
        takes, failures = made
        if failures:
            through = lambda view: replace(view, occupied=())
            more, failures = remake(through, [failure.seed for failure in failures])
            takes = sorted([*takes, *more], key=lambda take: take.seed)
        timed = [self._in_time(take, remake) for take in takes]
        idle = self._idle(timed, methods, progress)
        waited = [
            idling.after_waiting(take, idle.get(take.seed), wait) if wait > idling.SHORTEST else take
            for take, wait in timed
        ]
        return [self._told(take) for take in waited], failures

    def _in_time(self, take: Take, remake: Remake) -> tuple[Take, float]:
        """Return a take, maybe another one, and the seconds that it waits before it sets off."""
        wait, met = self._wait(take)
        blocked: list[Disc] = []
        for _ in range(AGAIN):
            if met is None:
                break
            blocked += met
            around = lambda view, discs=tuple(blocked): replace(view, occupied=(*view.occupied, *discs))
            other = next(iter(remake(around, [take.seed])[0]), None)
            if other is None:
                break
            later, met = self._wait(other)
            if met is None:
                return other, later
        return take, wait

    def _wait(self, take: Take) -> tuple[float, list[Disc] | None]:
        """Return the least seconds that a take has to wait, and the ground on which it meets somebody whenever it sets
        off, or None."""
        tracks = [track(take.motion, self.body, directing.RATE), *(other.track for other in self.others)]
        fixed = dict.fromkeys(range(1, len(tracks)), 0)
        flags = {(0, k): conflicts(tracks[0], tracks[k], timing.CLEARANCE) for k in fixed}
        longest = round(directing.LONGEST_WAIT * directing.RATE)
        made = timing.schedule(flags, [len(one) for one in tracks], [0] * len(tracks), longest, fixed)
        wait = made.starts[0] / directing.RATE
        return wait, directing.met(tracks, made, 0, made.stuck[0]) if 0 in made.stuck else None

    def _idle(
        self, timed: Sequence[tuple[Take, float]], methods: Mapping[str, Method], progress: Progress
    ) -> dict[int, Motion]:
        """Return the motions of takes that wait, by seed; a take that goes on from a pose waits in that."""
        rows = {
            take.seed: [idling.idle_step(self.view, take, wait)]
            for take, wait in timed
            if wait > idling.SHORTEST and not self.view.after and idling.IDLE in methods
        }
        made, _ = together.generate(rows, {seed: seed for seed in rows}, methods, progress)
        return {seed: other_body.fitted(take, self.body).motion for seed, take in made.items()}

    def _told(self, take: Take) -> Take:
        """Return a take with a sentence for each body that it is in."""
        own, remarks = track(take.motion, self.body, directing.RATE), list(take.remarks)
        for other in self.others:
            deepest = float(over_time(own, other.track).max(initial=0.0))
            if deepest > OVERLAP:
                remarks.append(f"The body is up to {100 * deepest:.0f} cm in that of '{other.name}'.")
        return replace(take, remarks=tuple(remarks))
