"""Sub-goals as arrows in the scene: made, found, put in order, and read. Light: the sidebar asks at every redraw.

An arrow belongs to a character by a custom property that points to it, is not its child: moving the character leaves
the sub-goals where they are, on floors, seats and beds.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Matrix

from ... import frames
from ...errors import SampError
from ..scene.candidates import OVERLAY_KEY

COLLECTION = "SAMP Sub-goals"
COLLECTION_KEY = "samp_sub_goals"
"""Custom property of the collection of arrows and ghosts, which is never rendered."""
NUMBER_KEY = "samp_sub_goal"
"""Custom property of an arrow: its number in the order of the take."""
OWNER_KEY = "samp_sub_goal_of"
"""Custom property of an arrow: its character."""
LENGTH = 0.5
STEEPEST = 0.2
"""Least horizontal component of an arrow's unit direction; below it the arrow has no facing."""
_NAMED = re.compile(r"Sub-goal \d+ of .*")


class Spot(NamedTuple):
    """Where an arrow is: point (3,) and yaw in radians, network frame, metres."""

    point: np.ndarray
    yaw: float


def is_arrow(obj: bpy.types.Object | None) -> bool:
    """Return whether an object is a sub-goal."""
    return obj is not None and NUMBER_KEY in obj and obj.type == "EMPTY"


def owner_of(arrow: bpy.types.Object) -> bpy.types.Object | None:
    """Return the character of a sub-goal, None where it was deleted from all scenes."""
    found = arrow.get(OWNER_KEY)
    return found if isinstance(found, bpy.types.Object) and found.users_scene else None


def of(context: bpy.types.Context, owner: bpy.types.Object | None) -> list[bpy.types.Object]:
    """Return the sub-goals of a character in the order of the take."""
    if owner is None:
        return []
    found = [obj for obj in context.scene.objects if is_arrow(obj) and owner_of(obj) == owner]
    return sorted(found, key=_order)


def listed(context: bpy.types.Context, owner: bpy.types.Object | None) -> list[bpy.types.Object]:
    """Return what `of` does for the arrows in the sub-goals' collection only: fast in scenes with many objects."""
    home = collection(context.scene)
    if home is None or owner is None:
        return []
    return sorted((obj for obj in home.objects if is_arrow(obj) and owner_of(obj) == owner), key=_order)


def owners(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Return the characters of the scene that have sub-goals."""
    found = (owner_of(obj) for obj in context.scene.objects if is_arrow(obj))
    present = {obj for obj in found if obj is not None and obj.name in context.scene.objects}
    return sorted(present, key=lambda obj: obj.name)


def current(
    context: bpy.types.Context, owner: bpy.types.Object | None, chosen: bpy.types.Object | None = None
) -> bpy.types.Object | None:
    """Return the sub-goal to work on: the active object, else the chosen one, else the last one."""
    found = listed(context, owner)
    active = context.view_layer.objects.active
    if active in found and active.select_get():
        return active
    if chosen in found:
        return chosen
    return found[-1] if found else None


def find(context: bpy.types.Context, name: str) -> bpy.types.Object:
    """Return the sub-goal of this name. Raise SampError where there is none."""
    found = context.scene.objects.get(name)
    if not is_arrow(found):
        raise SampError(f"There is no sub-goal '{name}'; choose one from the list of sub-goals.")
    return found


def create(context: bpy.types.Context, owner: bpy.types.Object, spot: Spot) -> bpy.types.Object:
    """Add an arrow after a character's other ones."""
    if not np.isfinite(spot.point).all():
        raise SampError(
            "The sub-goal's position is not a finite number; put the 3D cursor onto a floor, a seat or a bed."
        )
    arrow = bpy.data.objects.new("Sub-goal", None)
    arrow.empty_display_type, arrow.empty_display_size = "SINGLE_ARROW", LENGTH
    arrow.show_in_front, arrow.hide_render = True, True
    arrow[OVERLAY_KEY], arrow[OWNER_KEY] = True, owner
    arrow[NUMBER_KEY] = 1 + max((other[NUMBER_KEY] for other in of(context, owner)), default=0)
    home(context).objects.link(arrow)
    place(context, arrow, spot)
    number(context, owner)
    return arrow


def place(context: bpy.types.Context, arrow: bpy.types.Object, spot: Spot) -> None:
    """Put an arrow at a spot: local Z along the facing, local X up."""
    ahead, up = frames.to_blender(frames.yaw_direction(spot.yaw)), np.array([0.0, 0.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([up, np.cross(ahead, up), ahead], axis=1)
    matrix[:3, 3] = frames.to_blender(spot.point)
    arrow.matrix_world = Matrix(matrix.tolist())
    context.view_layer.update()


def read(arrow: bpy.types.Object) -> Spot:
    """Return where an arrow is. Raise SampError where it points up or down, or has no size."""
    world = np.array(arrow.matrix_world, dtype=np.float64)
    if not np.isfinite(world).all() or abs(np.linalg.det(world[:3, :3])) < 1e-9:
        raise SampError(f"'{arrow.name}' has a scale of zero; give it a scale.")
    ahead = frames.to_network(world[:3, 2])
    ahead /= np.linalg.norm(ahead)
    if np.linalg.norm(ahead[[0, 2]]) < STEEPEST:
        raise SampError(f"'{arrow.name}' points up or down; turn it to where the character will face.")
    return Spot(frames.to_network(world[:3, 3]), float(frames.direction_yaw(ahead)))


def move(context: bpy.types.Context, arrow: bpy.types.Object, by: int) -> None:
    """Move a sub-goal by some places in the order. Raise SampError at the end of the order."""
    owner = owner_of(arrow)
    order = of(context, owner)
    at = order.index(arrow)
    if not 0 <= at + by < len(order):
        end = "first" if by < 0 else "last"
        raise SampError(f"'{arrow.name}' is the {end} sub-goal already; move another one.")
    order.insert(at + by, order.pop(at))
    for count, obj in enumerate(order, start=1):
        obj[NUMBER_KEY] = count
    number(context, owner)


def number(context: bpy.types.Context, owner: bpy.types.Object) -> None:
    """Number a character's sub-goals from 1 and name them after it, except those that the artist has named."""
    order = of(context, owner)
    wanted = [f"Sub-goal {count} of {owner.name}" for count in range(1, len(order) + 1)]
    ours = [_NAMED.fullmatch(obj.name) is not None or obj.name == "Sub-goal" for obj in order]
    for count, obj in enumerate(order, start=1):
        if obj[NUMBER_KEY] != count:
            obj[NUMBER_KEY] = count
    wrong = [
        (obj, name)
        for obj, name, named in zip(order, wanted, ours, strict=True)
        if named and obj.name != name
    ]
    for obj, _ in wrong:
        obj.name = "Sub-goal (moving)"  # frees the names that are given next
    for obj, name in wrong:
        obj.name = name


def collection(scene: bpy.types.Scene) -> bpy.types.Collection | None:
    """Return the collection of a scene's sub-goals, or None."""
    return next((child for child in scene.collection.children_recursive if COLLECTION_KEY in child), None)


def home(context: bpy.types.Context) -> bpy.types.Collection:
    """Return the collection of the scene's sub-goals; create it if missing."""
    found = collection(context.scene)
    if found is None:
        found = bpy.data.collections.new(COLLECTION)
        found[COLLECTION_KEY], found.hide_render = True, True
        context.scene.collection.children.link(found)
    return found


def _order(arrow: bpy.types.Object) -> tuple[int, str]:
    return int(arrow[NUMBER_KEY]), arrow.name
