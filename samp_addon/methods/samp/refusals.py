"""Why there is no place on a target or no way to it: the objects that are in the way are found by leaving them out.

Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...errors import PathError, SampError
from ...motion import Goal
from ...scene.distance import solids
from ...scene.furniture import parts
from ...scene.geometry import area_vectors, extent
from ...scene.navmesh import navmesh as navigation
from ...scene.navmesh import path as paths
from ...scene.seats import seats
from ..scene_view import SceneView
from ..step import Step

MOST = 16
"""Objects that are left out one by one, the nearest ones."""

MOST_NAMED = 3
"""Objects that a message names."""

REACH = 1.5
"""Metres around the target within which objects can be in the way."""

CROUCHED = 1.2
"""Metres: height of a character under a low ceiling, to find out whether only the ceiling is in the way."""

LIMITS = {"sit": (0.22, 0.86), "lie": (0.08, 0.86)}
"""Heights over the floor of what is sat and lain on, metres."""

SIZE_COUNTS = 0.05
"""Metres of distance for each metre of size, in the order in which objects are suspected."""

LEVEL, STEP, DROP = 0.7, 0.3, 1.2
"""Vertical component of the normal of a floor, and metres over and below a place within which it is its floor."""

Works = Callable[[np.ndarray], bool]


def no_place(step: Step, scene: SceneView, floor: float | None, around: float) -> SampError:
    """Return the error for a target without a place to sit or lie.

    floor: height of the floor beside the target, or None for its own foot. around: metres around the target within
    which others obstruct.
    """
    target, others = scene.target, scene.geometry.without(scene.parts)
    low, high = extent(target)

    def works(keep: np.ndarray) -> bool:
        near = solids.overlapping_box(others.triangles[keep], low - around, high + around)
        return bool(seats.find_seats(target, step.action, floor, near, limit=1))

    blocking = _blocking(scene, works, low - around, high + around)
    if blocking:
        return SampError(_in_the_way(step, scene, blocking))
    return SampError(
        f"There is no place to {step.action} on '{step.target}'; {_advice(step, target, floor)}."
    )


def no_way(step: Step, scene: SceneView, start: np.ndarray, goal: Goal, error: SampError) -> SampError:
    """Return the error for a goal on the target that no path leads to. error: of the search."""
    others = scene.geometry.without(scene.parts)
    low, high = extent(scene.target)

    def works(keep: np.ndarray, agent: navigation.Agent | None = None) -> bool:
        triangles = np.concatenate([others.triangles[keep], scene.target])
        try:
            mesh = navigation.build(triangles, agent, cover=np.array([start, low, high]))
            # A free start may have been found on the roof.
            foot = np.array([goal.position[0], low[1], goal.position[2]])
            free = scene.start is None and not scene.after
            begin = mesh.ground.points(np.array(mesh.nearest(foot))) if free else start
            paths.plan_to_goal(mesh, begin, goal)
        except PathError:
            return False
        return True

    everything = np.ones(len(others), dtype=bool)
    agent = navigation.Agent()
    if works(everything, navigation.Agent(height=CROUCHED)):
        ceiling = _ceiling(scene, low, high, agent.height)
        if ceiling is not None:
            name, height = ceiling
            return SampError(
                f"'{name}' is only {height:.2f} m above the floor at '{step.target}', too low for a character that "
                f"needs {agent.height:.2f} m; raise the ceiling, or hide it in renders."
            )
    given = start if scene.start is not None or scene.after else low
    reach = np.minimum(low, given) - REACH, np.maximum(high, given) + REACH
    blocking = _blocking(scene, works, *reach, floor=(start, goal.position))
    if blocking:
        who = [scene.characters[name] for name in blocking if name in scene.characters]
        names = _listed(who or blocking)
        return SampError(f"{names} leaves no way to '{step.target}'; move it away, or choose another start.")
    text = str(error)
    return SampError(
        text if f"'{step.target}'" in text else f"'{step.target}' cannot be reached: {_lower(text)}"
    )


def walkable(scene: SceneView) -> navigation.NavMesh:
    """Return the navmesh of a scene. Raise SampError that names the ceiling where it is too low to walk under."""
    try:
        return scene.navmesh
    except PathError as error:
        raise nothing_walkable(scene, error) from error


def nothing_walkable(scene: SceneView, error: SampError) -> SampError:
    """Return the error for a scene in which nothing can be walked on, with the ceiling where it is too low."""
    try:
        navigation.build(scene.geometry.triangles, navigation.Agent(height=CROUCHED))
    except SampError:
        return error
    low, high = extent(scene.geometry.triangles)
    ceiling = _ceiling(scene, low, high, navigation.Agent().height)
    where = f"'{ceiling[0]}'" if ceiling else "The ceiling"
    return SampError(
        f"{where} is too low for a character, which needs {navigation.Agent().height:.2f} m; raise it, or hide it "
        "in renders."
    )


def _blocking(
    scene: SceneView, works: Works, low: np.ndarray, high: np.ndarray, floor: Sequence[np.ndarray] = ()
) -> list[str]:
    """Return the fewest objects without which it works, or none where it fails even without all of them.

    low, high: (3,) of the box in which objects are looked for. floor: start and goal (3,), whose floor is not
    in the way.
    """
    others = scene.geometry.without(scene.parts)
    near = (others.triangles.max(axis=1) >= low).all(axis=1) & (others.triangles.min(axis=1) <= high).all(
        axis=1
    )
    numbers = np.unique(others.object_ids[near])
    middle = (low + high) / 2
    away = [_distance(others.triangles[others.object_ids == number], middle) for number in numbers]
    numbers = numbers[np.argsort(away, kind="stable")]
    removed = [int(n) for n in numbers if not _is_floor(others.triangles[others.object_ids == n], floor)]
    removed = removed[:MOST]
    if not removed or not works(~np.isin(others.object_ids, removed)):
        return []
    # The farthest are put back first, so that the nearest are named.
    for number in removed[::-1]:
        rest = [other for other in removed if other != number]
        if works(~np.isin(others.object_ids, rest)):
            removed = rest
    return [others.names[number] for number in removed]


def _distance(triangles: np.ndarray, point: np.ndarray) -> float:
    low, high = extent(triangles)
    gap = np.maximum(np.maximum(low - point, point - high), 0)
    # Of two at the same distance the smaller one is more easily moved: a door in its wall.
    size = SIZE_COUNTS * np.linalg.norm(high - low)
    return float(np.linalg.norm(gap) + size + 1e-3 * np.linalg.norm((low + high) / 2 - point))


def _is_floor(triangles: np.ndarray, places: Sequence[np.ndarray]) -> bool:
    """Return whether triangles (F, 3, 3) have a level surface below one of the places (3,) and are wide, as a floor
    or a hill is."""
    if np.ptp(triangles, axis=(0, 1))[[0, 2]].min() < parts.LARGEST:
        return False
    vectors = area_vectors(triangles)
    level = triangles[np.abs(vectors[:, 1]) > LEVEL * np.linalg.norm(vectors, axis=1)]
    low, high = level.min(axis=1), level.max(axis=1)
    for place in places:
        over = ((low <= place) & (high >= place))[:, [0, 2]].all(axis=1)
        if (over & (high[:, 1] < place[1] + STEP) & (high[:, 1] > place[1] - DROP)).any():
            return True
    return False


def _in_the_way(step: Step, scene: SceneView, blocking: Sequence[str]) -> str:
    """Return a sentence on what is in the way of a seat."""
    who = [scene.characters[name] for name in blocking if name in scene.characters]
    if who:
        return (
            f"{_listed(dict.fromkeys(who))} is already on '{step.target}'; move that character away, "
            "or choose another target."
        )
    low, high = extent(scene.target)
    foot = min(extent(scene.geometry.triangles_of([name]))[0][1] for name in blocking)
    if foot > high[1] - 0.02 and foot > low[1] + 0.9:
        return (
            f"{_listed(blocking)} hangs only {foot - low[1]:.2f} m above the foot of '{step.target}', too low for a "
            f"body that has to {step.action} under it; raise it, or choose another target."
        )
    return f"{_listed(blocking)} is in the way of '{step.target}'; move them apart."


def _advice(step: Step, target: np.ndarray, floor: float | None) -> str:
    """Return what to do about a target that nothing else obstructs."""
    low, high = extent(target)
    floor = low[1] if floor is None else floor
    size, least, most = high - low, *LIMITS[step.action]
    if size.max() > 3 * parts.LARGEST:
        return f"it is {size.max():.0f} m large, so check that a unit of the scene is a metre"
    if size.max() < 0.2:
        return f"it is only {size.max():.2g} m large, so check that a unit of the scene is a metre"
    if high[1] - floor < least:
        return f"its top is only {max(high[1] - floor, 0):.2f} m above the floor; choose one of at least {least:.2f} m"
    if low[1] - floor > most:
        return f"it begins {low[1] - floor:.2f} m above the floor beside it; choose one that is at most {most:.2f} m up"
    if step.action == "lie":
        return "choose one with a flat, free surface of about 1.7 x 0.5 m below 0.85 m"
    return "choose one with a flat, free seat between 0.25 and 0.85 m above the floor and room for the legs"


def _ceiling(scene: SceneView, low: np.ndarray, high: np.ndarray, needed: float) -> tuple[str, float] | None:
    """Return the name and height over the floor of the lowest thing overhead around the target, below ``needed``."""
    triangles = scene.geometry.triangles
    near = ((triangles.max(1) >= low - 1.0) & (triangles.min(1) <= high + 1.0))[:, [0, 2]].all(axis=1)
    floor = low[1]
    foot = triangles[..., 1].min(axis=1)
    over = np.flatnonzero(near & (foot > floor + CROUCHED) & (foot < floor + needed))
    if not len(over):
        return None
    lowest = over[np.argmin(foot[over])]
    return scene.geometry.names[scene.geometry.object_ids[lowest]], float(foot[lowest] - floor)


def _listed(names: Sequence[str] | dict[str, None]) -> str:
    """Return names in quotes, joined in English."""
    quoted = [f"'{name}'" for name in names][:MOST_NAMED]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} or {quoted[-1]}"


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]
