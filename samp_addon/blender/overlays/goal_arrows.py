"""Goals as arrow objects in the scene, to move, select and delete like any object, and read back as Goals."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix

from ... import frames
from ...errors import NoPlaceError, PathError, SampError
from ...methods.samp import goals as sampling
from ...motion import Goal
from ...scene.furniture.floor import floor_beside
from ...scene.geometry import SceneGeometry, extent
from ...scene.navmesh import navmesh as navigation
from ...scene.remembered import by_content
from ...scene.seats import nearby, seats
from ...scene.seats.support import SupportMap
from ..character import characters
from ..scene import pieces, read_scene
from ..scene.candidates import OVERLAY_KEY
from ..scene.read_scene import Target

COLLECTION = "SAMP Goals"
TARGET_KEY = "samp_goal_target"
ACTION_KEY = "samp_goal_action"
ARROW_LENGTH = 0.4
STEEPEST_ARROW = 0.2
"""Least horizontal component of an arrow's unit direction; below it the arrow has no facing."""
REACH = 0.25
"""Largest distance in metres from an arrow to a place that supports a body."""
PLACED = 0.1
"""The same from a point that was given as the place itself."""


def sample_goals(
    context: bpy.types.Context, target: str, action: str = "sit", count: int = 5, seed: int = 0
) -> list[bpy.types.Object]:
    """Sample goals on an object with GoalNet and draw them, replacing its arrows for this action.

    target: name of an object, empty or collection. The rest of the scene, without characters, is an obstacle. Raise
    SampError where the target is unknown or has no place for a body.
    """
    furniture, around, floor = _surroundings(context, target, action)
    try:
        found = sampling.sample_goals(furniture.triangles, action, count, seed, around, floor)
    except NoPlaceError as error:
        raise SampError(str(error).replace("this object", f"'{furniture.name}'")) from error
    for arrow in arrows(context, furniture.name, action):
        bpy.data.objects.remove(arrow)
    return add_goals(context, found, furniture.name)


def add_goals(context: bpy.types.Context, goals: Sequence[Goal], target: str) -> list[bpy.types.Object]:
    """Draw an arrow for each goal, at the pelvis and in the direction of the facing."""
    collection = bpy.data.collections.get(COLLECTION) or bpy.data.collections.new(COLLECTION)
    if collection.name not in {child.name for child in context.scene.collection.children_recursive}:
        context.scene.collection.children.link(collection)
    made = []
    for goal in goals:
        arrow = bpy.data.objects.new(f"Goal {goal.action} {target}", None)
        arrow.empty_display_type, arrow.empty_display_size = "SINGLE_ARROW", ARROW_LENGTH
        arrow.show_in_front = True
        arrow[OVERLAY_KEY], arrow[TARGET_KEY], arrow[ACTION_KEY] = True, target, goal.action
        collection.objects.link(arrow)
        arrow.matrix_world = _matrix(goal)
        made.append(arrow)
    context.view_layer.update()
    return made


def arrows(context: bpy.types.Context, target: str, action: str | None = None) -> list[bpy.types.Object]:
    """Return the arrows of a target, for one action or all, sorted by name."""
    found = [
        obj
        for obj in context.scene.objects
        if obj.get(TARGET_KEY) == target and (action is None or obj.get(ACTION_KEY) == action)
    ]
    return sorted(found, key=lambda obj: obj.name)


def clear(context: bpy.types.Context) -> int:
    """Delete all arrows of the scene; return their number."""
    found = [obj for obj in context.scene.objects if obj.get(TARGET_KEY)]
    for arrow in found:
        bpy.data.objects.remove(arrow)
    return len(found)


def read_goals(
    context: bpy.types.Context,
    target: Target,
    action: str | None = None,
    scene: SceneGeometry | None = None,
) -> list[Goal]:
    """Return the goals of the arrows on a target, each snapped to the surface.

    scene: in which the target may lie on a frame or hang; left out, it stands on the floor.
    If any of the arrows are selected, only those are used. Raise SampError, naming the arrow, where it points up or
    down or nothing below it supports a body.
    """
    found = arrows(context, target.name, action)
    # select_get fails for objects outside the view layer.
    visible = [arrow for arrow in found if arrow.name in context.view_layer.objects]
    found = [arrow for arrow in visible if arrow.select_get()] or found
    if not found:
        return []
    support = seats.support_map(target.triangles, None if scene is None else _floor(scene, target))
    return [_snap(support, arrow) for arrow in found]


def goal_at(target: Target, action: str, point: np.ndarray, yaw: float) -> Goal:
    """Return the goal on the surface of a target at a point (3,), facing a yaw in radians; network frame.

    Raise SampError where nothing below the point supports a body.
    """
    support = seats.support_map(target.triangles)
    goal = seats.snap_to_map(support, nearby.goal_at(point, yaw, action), PLACED, enough=0.0)
    if goal is None:
        raise SampError(
            f"There is no place to {action} at this point of '{target.name}'; choose another one."
        )
    return goal


def _snap(support: SupportMap, arrow: bpy.types.Object) -> Goal:
    goal = read_arrow(arrow)
    snapped = seats.snap_to_map(support, goal, REACH)
    if snapped is None:
        raise SampError(
            f"There is no place to {goal.action} at the arrow '{arrow.name}'; move, turn or delete the arrow."
        )
    return snapped


def read_arrow(arrow: bpy.types.Object) -> Goal:
    """Return the goal of an arrow, network frame, not snapped. Raise SampError where it points up or down."""
    world = np.array(arrow.matrix_world)
    along = frames.to_network(world[:3, 2])
    along = along / max(np.linalg.norm(along), 1e-12) * [1.0, 0.0, 1.0]
    length = np.linalg.norm(along)
    if length < STEEPEST_ARROW:
        raise SampError(
            f"The arrow '{arrow.name}' points up or down; turn it to where the character will face."
        )
    return Goal(frames.to_network(world[:3, 3]), along / length, arrow.get(ACTION_KEY, "sit"))


def _matrix(goal: Goal) -> Matrix:
    """Return the world matrix of an arrow: local Z along the goal's direction, local X up."""
    ahead, up = frames.to_blender(goal.direction), np.array([0.0, 0.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([up, np.cross(ahead, up), ahead], axis=1)
    matrix[:3, 3] = frames.to_blender(goal.position)
    return Matrix(matrix.tolist())


def _surroundings(
    context: bpy.types.Context, target: str, action: str
) -> tuple[Target, np.ndarray, float | None]:
    """Return the target with what belongs to it, the triangles (G, 3, 3) of the rest of the scene without characters,
    and the height of the floor beside the target or None where it stands there; network frame."""
    people = characters.people(context)
    scene = read_scene.read_scene(context, people)
    scene, furniture = pieces.piece(context, scene, read_scene.read_target(context, target, people), action)
    return furniture, scene.without(furniture.parts).triangles, _floor(scene, furniture)


def _floor(scene: SceneGeometry, target: Target) -> float | None:
    """Return the height of the floor beside a target, or None where it stands there or nothing is walkable."""
    return _height_beside(scene.triangles, target.triangles)


@by_content(kept=8)
def _height_beside(scene: np.ndarray, target: np.ndarray) -> float | None:
    """Return the height of the floor beside a target, see _floor; kept, since it does not change while an arrow is
    dragged. scene, target: triangles (F, 3, 3)."""
    try:
        mesh = navigation.build(scene, cover=np.stack(extent(target)))
    except PathError:
        return None
    return floor_beside(mesh, target)
