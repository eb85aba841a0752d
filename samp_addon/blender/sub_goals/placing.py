"""Bodies at the sub-goals of a character: drawn, kept, posed by the artist, brought up to date, and read for a take."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames, skeleton
from ...body import betas, proportions
from ...errors import SampError
from ...methods import registry
from ...methods.long_term.sub_goals.bodies import SubGoalBodies
from ...methods.long_term.sub_goals.places import Place
from ...methods.scene_view import SceneView
from ...motion import Motion
from ...vocabulary import SEATED
from ..character import armature, character, characters
from ..scene import read_scene
from . import arrows, ghosts, stored
from .arrows import Spot

METHOD = "long_term"
APART = 100
"""Draws between those of two new sub-goals, so that no two begin with the same body."""
ROOM = 2.0
"""Metres beyond the places of a scene that was read within which it serves other places too."""


@dataclass(frozen=True)
class _Read:
    """What draws bodies in a scene that was read, by a method. digest: of the scene's triangles and the character's
    shape. low, high: (3,) of the places in it."""

    method: object
    digest: bytes
    low: np.ndarray
    high: np.ndarray
    tools: SubGoalBodies


_last: list[_Read] = []


def add(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    point: np.ndarray,
    yaw: float | None = None,
    style: float = 0.1,
) -> bpy.types.Object:
    """Add a sub-goal with a body and return its arrow.

    point: (3,) on what carries the body, network frame. yaw: radians; left out, a body on furniture looks out of its
    front, another one to where it came from. Raise SampError, adding nothing, where no body can be.
    """
    wanted = _towards(context, owner, point) if yaw is None else yaw
    arrow = arrows.create(context, owner, Spot(point, wanted))
    arrow[stored.DRAW_KEY], arrow[stored.STYLE_KEY], arrow[stored.PINNED_KEY] = (
        APART * int(arrow[arrows.NUMBER_KEY]),
        style,
        False,
    )
    try:
        tools = _tools(context, owner)
        if yaw is None:
            arrows.place(context, arrow, Spot(point, tools.facing(point, wanted, arrow.name)))
        _fit(context, arrow, tools)
    except Exception:
        remove(context, arrow)
        raise
    return arrow


def remove(context: bpy.types.Context, arrow: bpy.types.Object) -> None:
    """Delete a sub-goal and its ghost."""
    owner, ghost = arrows.owner_of(arrow), ghosts.find(arrow)
    if ghost is not None:
        ghosts.remove(ghost)
    bpy.data.objects.remove(arrow)
    if owner is not None:
        arrows.number(context, owner)
    _tidy(context)


def clear(context: bpy.types.Context, owner: bpy.types.Object | None) -> int:
    """Delete all sub-goals of a character, and those of deleted ones; return their number."""
    found = [obj for obj in context.scene.objects if arrows.is_arrow(obj)]
    found = [arrow for arrow in found if arrows.owner_of(arrow) in (owner, None)]
    for arrow in found:
        remove(context, arrow)
    _tidy(context)
    return len(found)


def another(context: bpy.types.Context, arrow: bpy.types.Object, style: float | None = None) -> None:
    """Draw the next body of a sub-goal. style: 0 to 1; left out, as before. Raise SampError for a pinned one."""
    if stored.is_pinned(arrow):
        raise SampError(f"The body of '{arrow.name}' is pinned; unpin it to draw another one.")
    if style is not None:
        arrow[stored.STYLE_KEY] = style
    arrow[stored.DRAW_KEY] = int(arrow.get(stored.DRAW_KEY, 0)) + 1
    _fit(context, arrow, _tools(context, _owner(arrow)))


def use_pose(context: bpy.types.Context, arrow: bpy.types.Object, here: bool = False) -> None:
    """Make the character's current pose the body of a sub-goal, and pin it.

    here: move the sub-goal to where the character is now. Raise SampError where no body can be.
    """
    owner = _owner(arrow)
    pose = proportions.adapt(armature.posed(owner), skeleton.default_rest_joints())
    tools, before = _tools(context, owner), arrow.matrix_world.copy()
    try:
        if here:
            yaw = float(frames.direction_yaw(pose.headings()[0]))
            arrows.place(context, arrow, Spot(_below(tools, pose), yaw))
        place = _place(arrow, tools)
    except SampError:
        arrow.matrix_world = before
        context.view_layer.update()
        raise
    body = Motion(pose.root, pose.rotations) if here else tools.posed(place, pose)
    arrow[stored.PINNED_KEY] = True
    stored.store(context, arrow, body, place.action)


def update(context: bpy.types.Context, owner: bpy.types.Object) -> list[str]:
    """Fit bodies again where arrows were moved, copied or deleted; return the problems of all sub-goals."""
    context.view_layer.update()
    for ghost in ghosts.orphans(context.scene):
        ghosts.remove(ghost)
    found, home = arrows.of(context, owner), arrows.collection(context.scene)
    arrows.number(context, owner)
    for arrow in found:
        if home is not None and arrow.name not in home.objects:
            home.objects.link(arrow)  # also in the list where the artist has sorted it elsewhere
    # Problems may have gone with the furniture that caused them.
    stale = [arrow for arrow in found if stored.is_stale(arrow) or stored.problem(arrow)]
    try:
        tools = _tools(context, owner) if stale else None
    except SampError as error:
        for arrow in stale:
            stored.refuse(context, arrow, str(error))
        stale = []
    for arrow in stale:
        try:
            _fit(context, arrow, tools)
        except SampError as error:
            stored.refuse(context, arrow, str(error))
    return [stored.problem(arrow) for arrow in found if stored.problem(arrow)]


def chosen(
    context: bpy.types.Context, owner: bpy.types.Object | None
) -> tuple[list[tuple[np.ndarray, float]], list[Motion]]:
    """Return the places of a character's sub-goals in order, and the bodies there, each one frame; network frame.

    Raise SampError, naming the sub-goal, where no body fits.
    """
    if owner is None or not arrows.of(context, owner):
        return [], []
    problems = update(context, owner)
    if problems:
        raise SampError(problems[0])
    found = arrows.of(context, owner)
    return [tuple(arrows.read(arrow)) for arrow in found], [stored.body(arrow) for arrow in found]


def _fit(context: bpy.types.Context, arrow: bpy.types.Object, tools: SubGoalBodies) -> None:
    """Put a body at an arrow: the next drawn one, or the pinned one. Raise SampError where none fits."""
    place = _place(arrow, tools)
    if not stored.is_pinned(arrow) or stored.POSE_KEY not in arrow:
        number, style = int(arrow.get(stored.DRAW_KEY, 0)), float(arrow.get(stored.STYLE_KEY, 0.1))
        stored.store(context, arrow, tools.draw(place, number, style), place.action)
        return
    kept = arrow.get(stored.ACTION_KEY, place.action)
    if (kept in SEATED) != (place.action in SEATED):
        there, advice = ("furniture", "the floor") if place.action in SEATED else ("the floor", "furniture")
        raise SampError(
            f"'{arrow.name}' is on {there} now and its pinned body is not; unpin it, or move it onto {advice}."
        )
    stored.store(context, arrow, tools.posed(place, stored.body(arrow)), kept)


def _place(arrow: bpy.types.Object, tools: SubGoalBodies) -> Place:
    spot = arrows.read(arrow)
    return tools.place(spot.point, spot.yaw, f"'{arrow.name}'")


def _owner(arrow: bpy.types.Object) -> bpy.types.Object:
    """Return the character of a sub-goal. Raise SampError where it was deleted."""
    owner = arrows.owner_of(arrow)
    if owner is None:
        raise SampError(f"The character of '{arrow.name}' was deleted; delete the sub-goal too.")
    return owner


def _towards(context: bpy.types.Context, owner: bpy.types.Object, point: np.ndarray) -> float:
    """Return the facing of a new sub-goal: on from the last one, else from where the character stands."""
    found = arrows.of(context, owner)
    last = arrows.read(found[-1]) if found else Spot(*armature.standing_floor(owner))
    way = (point - last.point) * [1.0, 0.0, 1.0]
    return float(frames.direction_yaw(way)) if np.linalg.norm(way) > 0.3 else last.yaw


def _below(tools: SubGoalBodies, pose: Motion) -> np.ndarray:
    """Return the point (3,) on what carries a pose: the highest surface below its pelvis."""
    from ...methods.long_term.sub_goals import places

    surfaces = tools.surfaces
    for depth in np.arange(0.1, 1.3, 0.2):
        point = pose.root[0] - [0.0, depth, 0.0]
        height = places.support(surfaces.triangles, point)
        if height is not None:
            return np.array([point[0], height, point[2]])
    joints = pose.forward_kinematics()[0][0]
    return np.array([pose.root[0, 0], joints[:, 1].min(), pose.root[0, 2]])


def _tools(context: bpy.types.Context, owner: bpy.types.Object) -> SubGoalBodies:
    """Return what draws bodies in the scene as it is now; a scene that has not changed is prepared once."""
    points = np.array([arrow.matrix_world.translation for arrow in arrows.of(context, owner)])
    points = frames.to_network(points.reshape(-1, 3))
    geometry = read_scene.read_scene(context, characters.people(context))
    shapes = character.shapes_of(owner)
    state = geometry.triangles.tobytes() + str(sorted(shapes.items())).encode()
    digest = hashlib.blake2b(state, digest_size=16).digest()
    method = registry.find(METHOD)
    for known in _last:
        inside = (points >= known.low - ROOM).all() and (points <= known.high + ROOM).all()
        if known.method is method and known.digest == digest and inside:
            return known.tools
    view = SceneView(geometry, sub_goals=[(point, 0.0) for point in points], betas=betas.from_named(shapes))
    tools = method.bodies(view)
    _last[:] = [_Read(method, digest, points.min(0), points.max(0), tools)]
    return tools


def _tidy(context: bpy.types.Context) -> None:
    """Delete ghosts without arrows, and the collection once it is empty."""
    for ghost in ghosts.orphans(context.scene):
        ghosts.remove(ghost)
    home = arrows.collection(context.scene)
    if home is not None and not home.objects and not home.children:
        bpy.data.collections.remove(home)
