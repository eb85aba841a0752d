"""The character and the sub-goal that the sidebar and the operators of sub-goals work on. Light: asked at redraws."""

from __future__ import annotations

import bpy

from ..blender.sub_goals import arrows


def owner(context: bpy.types.Context) -> bpy.types.Object | None:
    """Return the character whose sub-goals are shown: that of the active sub-goal, the chosen one, the active one,
    else the only one that has any."""
    active = context.view_layer.objects.active
    if arrows.is_arrow(active) and active.select_get():
        return arrows.owner_of(active)
    chosen = context.scene.samp.character
    if chosen is not None:
        return chosen
    home = arrows.collection(context.scene)
    if home is None:
        return None
    found = {arrows.owner_of(obj) for obj in home.objects if arrows.is_arrow(obj)} - {None}
    if active in found:
        return active
    return next(iter(found)) if len(found) == 1 else None


def current(context: bpy.types.Context) -> bpy.types.Object | None:
    """Return the active sub-goal, or None."""
    return arrows.current(context, owner(context), context.scene.samp.sub_goal)


def character(context: bpy.types.Context, name: str = "") -> bpy.types.Object:
    """Return the character that gets a new sub-goal. Raise SampError where there is none, or several."""
    from ..blender.character import armature

    found = None if name else owner(context)
    return armature.find(context, name or (found.name if found is not None else ""))


def activate(context: bpy.types.Context, arrow: bpy.types.Object) -> None:
    """Make a sub-goal the active one, and in Object Mode the active object too, ready to be moved."""
    context.scene.samp.sub_goal = arrow
    if context.mode != "OBJECT" or arrow.name not in context.view_layer.objects or not arrow.visible_get():
        return
    for obj in context.selected_objects:
        obj.select_set(False)
    arrow.select_set(True)
    context.view_layer.objects.active = arrow


def index(settings: bpy.types.PropertyGroup) -> int:
    """Return the place of the active sub-goal among the objects of its collection, or -1."""
    home, arrow = arrows.collection(bpy.context.scene), current(bpy.context)
    if home is None or arrow is None:
        return -1
    return home.objects.find(arrow.name)


def set_index(settings: bpy.types.PropertyGroup, place: int) -> None:
    """Make the sub-goal at a place among the objects of its collection the active one."""
    home = arrows.collection(bpy.context.scene)
    if home is not None and 0 <= place < len(home.objects) and arrows.is_arrow(home.objects[place]):
        activate(bpy.context, home.objects[place])
