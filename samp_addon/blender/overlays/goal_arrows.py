"""Goals as arrows in the artist's scene: drawn, moved, chosen and deleted like any object, and read back as Goals."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix

from ... import frames
from ...errors import SampError
from ...methods.samp import goals as sampling
from ...motion import Goal
from ...scene.seats import seats
from ...scene.seats.support import SupportMap
from ..character import armature
from ..scene import read_scene
from ..scene.read_scene import OVERLAY_KEY, Target

COLLECTION = "SAMP Goals"
TARGET_KEY = "samp_goal_target"
ACTION_KEY = "samp_goal_action"
ARROW_LENGTH = 0.4
STEEPEST_ARROW = 0.2
"""Least horizontal part of an arrow's direction; below it the arrow points at no side."""
REACH = 0.25
"""Metres by which an arrow may lie beside a place that carries."""


def sample_goals(
    context: bpy.types.Context, target: str, action: str = "sit", count: int = 5, seed: int = 0
) -> list[bpy.types.Object]:
    """Draws goals on an object by GoalNet as arrows, in place of the arrows it had for this action.

    target: name of an object, empty or collection. The rest of the scene, without characters, is what a body must
    not hit. Raises SampError where the target is unknown or carries nobody.
    """
    furniture, around = _surroundings(context, target)
    found = sampling.sample_goals(furniture.triangles, action, count, seed, around)
    for arrow in arrows(context, furniture.name, action):
        bpy.data.objects.remove(arrow)
    return add_goals(context, found, furniture.name)


def add_goals(context: bpy.types.Context, goals: Sequence[Goal], target: str) -> list[bpy.types.Object]:
    """An arrow for each goal: it stands at the pelvis and points where the character will face."""
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
    """The scene's arrows of a target, of one action or of all, by name."""
    found = [
        obj
        for obj in context.scene.objects
        if obj.get(TARGET_KEY) == target and (action is None or obj.get(ACTION_KEY) == action)
    ]
    return sorted(found, key=lambda obj: obj.name)


def clear(context: bpy.types.Context) -> int:
    """Takes all arrows of the scene away; returns how many there were."""
    found = [obj for obj in context.scene.objects if obj.get(TARGET_KEY)]
    for arrow in found:
        bpy.data.objects.remove(arrow)
    return len(found)


def read_goals(context: bpy.types.Context, target: Target, action: str | None = None) -> list[Goal]:
    """The goals that the artist's arrows on a target ask for, each put onto the real surface.

    Where some of the arrows are selected, only those count: that is how an artist chooses. Raises SampError, naming
    the arrow, where it points up or down or where nothing under it carries a body.
    """
    found = arrows(context, target.name, action)
    # Hidden objects and those of other view layers cannot be asked whether they are selected.
    shown = [arrow for arrow in found if arrow.name in context.view_layer.objects]
    found = [arrow for arrow in shown if arrow.select_get()] or found
    if not found:
        return []
    support = seats.support_map(target.triangles)
    return [_on_surface(support, arrow) for arrow in found]


def _on_surface(support: SupportMap, arrow: bpy.types.Object) -> Goal:
    goal = read_arrow(arrow)
    snapped = seats.snap_to_map(support, goal, REACH)
    if snapped is None:
        raise SampError(
            f"Nobody can {goal.action} where the arrow '{arrow.name}' stands; move or turn it, or delete it."
        )
    return snapped


def read_arrow(arrow: bpy.types.Object) -> Goal:
    """The goal of an arrow as it stands, network frame. Raises SampError where it points up or down."""
    world = np.array(arrow.matrix_world)
    along = frames.to_network(world[:3, 2])
    along = along / max(np.linalg.norm(along), 1e-12) * [1.0, 0.0, 1.0]
    length = np.linalg.norm(along)
    if length < STEEPEST_ARROW:
        raise SampError(f"The arrow '{arrow.name}' points up or down; turn it to where the character faces.")
    return Goal(frames.to_network(world[:3, 3]), along / length, arrow.get(ACTION_KEY, "sit"))


def _matrix(goal: Goal) -> Matrix:
    """World matrix of an arrow, whose own Z points along the goal's direction and whose X points up."""
    ahead, up = frames.to_blender(goal.direction), np.array([0.0, 0.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([up, np.cross(ahead, up), ahead], axis=1)
    matrix[:3, 3] = frames.to_blender(goal.position)
    return Matrix(matrix.tolist())


def _surroundings(context: bpy.types.Context, target: str) -> tuple[Target, np.ndarray]:
    """The target and the triangles (G, 3, 3) of all else that stands still, network frame."""
    people = [obj for obj in context.scene.objects if armature.is_smplx(obj)]
    furniture = read_scene.read_target(context, target, people)
    return furniture, read_scene.read_scene(context, people).without(furniture.parts).triangles
