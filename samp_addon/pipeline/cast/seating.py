"""Places on the furniture of a cast, and the ground that each member leaves to the others. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...methods.samp import refusals
from ...methods.scene_view import SceneView
from ...methods.step import Step
from ...scene.distance import solids
from ...scene.furniture.floor import floor_beside
from ...scene.geometry import extent
from ...scene.navmesh import navmesh as navigation
from ...scene.navmesh import occupied
from ...scene.navmesh.occupied import Disc
from ...scene.seats import seats
from . import assignment, pausing
from .assignment import Place
from .pausing import Pause
from .role import Other, Role

REACH = 1.0
"""Metres around a piece in which other things can obstruct a body on it."""

STANDING = 0.25
"""Radius in metres of a body that stands."""

SITTING = ((0.0, 0.28), (0.4, 0.22))
"""Metres before the pelvis, and radius, of the discs under a seated body: hips and knees."""

MARGIN = 0.05
"""Metres between a member's start and the ground that is left to another one."""

BESIDE = 0.7
"""Metres between two members that stand beside each other in the end."""

START_DISTANCE = (1.5, 3.5)
"""Metres from its goal at which a member without a start begins."""


@dataclass(frozen=True)
class Seated:
    """A role that has its place.

    option: number of its piece. place: on it; None where the method chooses. exact: whether the method must take the
    place, because the piece is shared. pause: where it waits for others on its way, or None.
    """

    role: Role
    option: int
    place: Place | None
    exact: bool = False
    pause: Pause | None = None

    @property
    def steps(self) -> list[tuple[Step, SceneView]]:
        """Steps and views, the last one with its goal where the piece is shared."""
        steps = self.role.steps(self.option)
        if self.exact and self.place is not None:
            step, view = steps[-1]
            steps[-1] = step, replace(view, goals=[self.place.goal])
        if self.pause is not None:
            steps.insert(0, pausing.step(self.pause, steps[0][1], steps[0][0]))
        return steps

    def discs(self) -> list[Disc]:
        """Return the ground on which the member stands in the beginning and is in the end."""
        first, last = self.role.views[self.option][0], self.role.views[self.option][-1]
        found = [] if first.start is None else [(first.start[0], STANDING)]
        if self.place is not None:
            goal = self.place.goal
            found += [(goal.position + ahead * goal.direction, radius) for ahead, radius in SITTING]
        elif last.destination is not None:
            found.append((last.destination[0], STANDING))
        return found


def seat(roles: Sequence[Role], others: Sequence[Other]) -> list[Seated | None]:
    """Return each role with its place, None for those for whom none is left."""
    names = list(dict.fromkeys(name for role in roles if role.seated for name in role.pieces))
    wanted = {name: sum(role.seated and name in role.pieces for role in roles) for name in names}
    views = {
        name: (view[-1], role.action)
        for role in roles
        if role.seated
        for name, view in zip(role.pieces, role.views, strict=True)
    }
    pelvises = np.array([other.pelvis for other in others]).reshape(-1, 3)
    shared = {name for name in names if wanted[name] > 1 or near(views[name][0], pelvises)}
    places = [
        place
        for number, name in enumerate(names)
        if name in shared
        for place in places_on(number, *views[name])
    ]
    places = _without_perches(places)
    choosing = [k for k, role in enumerate(roles) if role.seated and shared & set(role.pieces)]
    found: list[Seated | None] = [Seated(role, 0, None) for role in roles]
    chosen = assignment.assign(
        [_from(roles[k]) for k in choosing],
        [[names.index(name) for name in roles[k].pieces] for k in choosing],
        places,
        pelvises,
    )
    taken = [names[place.piece] for place in chosen if place is not None]
    for k, place in zip(choosing, chosen, strict=True):
        if place is None:
            found[k] = None
            continue
        name = names[place.piece]
        exact = taken.count(name) > 1 or near(views[name][0], pelvises)
        found[k] = Seated(roles[k], roles[k].pieces.index(name), place, exact)
    return found


def with_starts(roles: Sequence[Role], seed: int) -> list[Role]:
    """Return the roles, those without a start with a free one, apart from the others'."""
    rng, found = np.random.default_rng(seed), list(roles)
    discs = [(role.views[0][0].start[0], STANDING) for role in roles if role.views[0][0].start is not None]
    for k, role in enumerate(roles):
        view = role.views[0][0]
        if view.start is not None or view.after or len(view.sub_goals) or view.camera is not None:
            continue
        mesh = occupied.without(view.navmesh, discs)
        near = mesh.points.mean(0) if view.target is None else np.mean(extent(view.target), axis=0)
        start = navigation.free_place(mesh, near, START_DISTANCE, rng)
        discs.append((start[0], STANDING))
        found[k] = role.starting(start)
    return found


def apart(roles: Sequence[Role]) -> list[Role]:
    """Return the roles, those that walk to about the same place with destinations beside each other."""
    found, taken = list(roles), []
    for k, role in enumerate(roles):
        view = role.views[0][-1]
        if role.seated or view.destination is None:
            continue
        place, yaw = view.destination
        if any(_gap(place, other) < BESIDE for other in taken):
            points = view.navmesh.points
            gaps = np.array([np.linalg.norm((points - other)[:, [0, 2]], axis=-1) for other in taken])
            free = points[(gaps >= BESIDE).all(0)]
            if len(free):
                place = free[np.linalg.norm(free - place, axis=-1).argmin()]
                found[k] = role.ending((place, yaw))
        taken.append(place)
    return found


def around_others(seated: Seated, others: Sequence[Seated], blocked: Sequence[Disc] = ()) -> Seated:
    """Return a role whose paths lead around the places of the other members, and around blocked ground."""
    start = _from(seated.role)
    destination = seated.role.views[seated.option][-1].destination
    end = None if destination is None else destination[0]
    discs = [disc for other in others for disc in other.discs()] + list(blocked)
    kept = left_to_others(discs, [own for own in (start, end) if own is not None])
    views = tuple(tuple(replace(view, occupied=kept) for view in own) for own in seated.role.views)
    return replace(seated, role=replace(seated.role, views=views))


def left_to_others(discs: Sequence[Disc], own: Sequence[np.ndarray]) -> list[Disc]:
    """Return the ground that is left to others, smaller where it would cover one of a member's own places (3,): its
    start and destination stay free, since a body that stands there now will have left."""
    kept = []
    for centre, radius in discs:
        room = min((_gap(centre, place) for place in own), default=np.inf)
        free = min(radius, room - navigation.Agent().radius - MARGIN)
        if free > 0:
            kept.append((centre, free))
    return kept


def places_on(number: int, view: SceneView, action: str) -> list[Place]:
    """Return the places on a piece: the artist's goals, else those found by geometry."""
    own = [goal for goal in view.goals if goal.action == action]
    if own:
        return [Place(number, goal, 1.0) for goal in own]
    low, high = extent(view.target)
    around = view.geometry.without(view.parts).triangles
    near = solids.overlapping_box(around, low - REACH, high + REACH)
    floor = floor_beside(view.navmesh, view.target)
    found = seats.find_seats(view.target, action, floor, near, assignment.MOST)
    return [Place(number, each.goal, each.score, each.surface) for each in found]


def obstruction(role: Role) -> str:
    """Return why nobody at all fits on a role's pieces, as of the first of them; empty where somebody does."""
    if any(places_on(k, views[-1], role.action) for k, views in enumerate(role.views)):
        return ""
    step, view = role.steps(0)[-1]
    return str(refusals.no_place(step, view, floor_beside(view.navmesh, view.target), REACH))


def _without_perches(places: Sequence[Place]) -> list[Place]:
    """Return the places without those to sit on that are as high as a table, where there are lower ones."""
    low = [place for place in places if place.surface < seats.PERCH]
    return low or list(places)


def near(view: SceneView, pelvises: np.ndarray) -> bool:
    """Whether a body that is not of the cast is on a piece, or right beside it."""
    if not len(pelvises):
        return False
    low, high = extent(view.target)
    inside = (pelvises > low - assignment.APART["sit"]) & (pelvises < high + assignment.APART["sit"])
    return bool(inside.all(1).any())


def _from(role: Role) -> np.ndarray | None:
    start = role.views[0][0].start
    return None if start is None else start[0]


def _gap(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm((a - b)[[0, 2]]))
