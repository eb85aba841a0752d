"""Settings of the sidebar, saved with the scene (``scene.samp``)."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..blender.character import measures
from ..blender.sub_goals import arrows
from . import job_from_settings, method_options, sub_goal_settings
from .cast.settings import SAMP_PG_member
from .farm.settings import SAMP_PG_farm
from .parts.choices import is_character, is_target

ACTIONS = (
    ("sit", "Sit", "Walk to the target and sit down"),
    ("lie", "Lie", "Walk to the target and lie down"),
    ("walk", "Walk", "Walk to the target, or to the 3D cursor"),
    ("run", "Run", "Run to the target, or to the 3D cursor"),
)


def _is_sub_goal(settings: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    return arrows.is_arrow(obj)


def _owner(settings: bpy.types.PropertyGroup) -> bpy.types.Object | None:
    """Return the character of the takes list: the chosen one, or the active armature."""
    if settings.character is not None:
        return settings.character
    active = bpy.context.view_layer.objects.active
    return active if active is not None and active.type == "ARMATURE" else None


def _get_take(settings: bpy.types.PropertyGroup) -> int:
    """Return the index in bpy.data.actions of the character's active Action, or -1."""
    owner = _owner(settings)
    action = owner.animation_data.action if owner is not None and owner.animation_data else None
    return -1 if action is None else bpy.data.actions.find(action.name)


def _set_take(settings: bpy.types.PropertyGroup, index: int) -> None:
    """Show the clicked take on the character."""
    from ..blender.actions import notes
    from ..blender.rigs import performers
    from ..blender.takes import take_list
    from ..errors import SampError

    actions = bpy.data.actions
    if not 0 <= index < len(actions) or not notes.is_take(actions[index]):
        return
    try:
        owner = performers.find(bpy.context, job_from_settings.character_name(settings))
        take_list.show(bpy.context, owner, actions[index])
    except SampError:
        # The character may be linked or deleted: there is nothing to show the take on.
        return


class SAMP_PG_step(bpy.types.PropertyGroup):
    """One step of a take."""

    method: EnumProperty(
        name="Method", description="Method that generates the motion of this step", items=method_options.items
    )
    action: EnumProperty(name="Action", description="Action of this step", items=ACTIONS)
    target: PointerProperty(
        name="Target", description="Furniture of this step", type=bpy.types.Object, poll=is_target
    )
    place: FloatVectorProperty(
        name="Location",
        description="Destination if there is no target, or the exact place on it with Custom Facing",
        subtype="TRANSLATION",
    )
    use_yaw: BoolProperty(
        name="Custom Facing", description="End exactly at the location, facing a given direction"
    )
    yaw: FloatProperty(
        name="Facing", description="Rotation to the left from facing -Y, seen from above", subtype="ANGLE"
    )
    posture: StringProperty(
        name="Posture", description="Posture in place of the one above the button, as chosen by Place"
    )


class SAMP_PG_settings(bpy.types.PropertyGroup):
    """Settings of the sidebar."""

    character: PointerProperty(
        name="Character",
        description="SMPL-X armature, or a Mixamo, Rigify, Unreal or other rig; if empty, the selected SMPL-X "
        "armature, the only one, or a new human",
        type=bpy.types.Object,
        poll=is_character,
    )
    method: EnumProperty(
        name="Method", description="Method that generates the motion", items=method_options.items
    )
    action: EnumProperty(name="Action", description="Action of the character at the target", items=ACTIONS)
    target: PointerProperty(
        name="Target",
        description="Furniture for the action; if empty, the active object",
        type=bpy.types.Object,
        poll=is_target,
    )
    seed: IntProperty(
        name="Seed", description="Seed of the random numbers; increased after each press", min=0
    )
    variants: IntProperty(name="Takes", description="Number of takes to generate", default=1, min=1, max=64)
    style: FloatProperty(
        name="Style",
        description="Amount of variation between takes",
        default=0.1,
        min=0.0,
        max=1.0,
        soft_max=0.4,
        step=1,
    )
    hold: FloatProperty(
        name="Hold",
        description="Time to keep the final pose, in seconds",
        default=2.0,
        min=0.0,
        max=600.0,
        subtype="TIME_ABSOLUTE",
    )
    speed: FloatProperty(
        name="Speed", description="Speed relative to captured motion", default=1.0, min=0.5, max=2.0, step=5
    )
    start_from: EnumProperty(
        name="Start",
        description="Where the next take starts",
        items=(
            (
                "MARKER",
                "Start at Marker",
                "Start at the character's start marker, standing",
                "EMPTY_SINGLE_ARROW",
                0,
            ),
            (
                "POSE",
                "Continue From Here",
                "Continue from the current pose at the current frame",
                "FORWARD",
                1,
            ),
        ),
    )
    refine: BoolProperty(
        name="Refine",
        description="Correct contact, penetration and foot slide of each take; this takes longer",
    )
    fit_range: BoolProperty(
        name="Fit Frame Range",
        description="Set the end of the scene's frame range to the end of the new take",
        default=True,
    )
    mark_takes: BoolProperty(
        name="Markers",
        description="Add markers to the Action of each new take where its phases begin",
    )
    as_strip: BoolProperty(
        name="Strip at Playhead",
        description="Put the new take as a strip onto an NLA track of its own, from the current frame on",
    )
    only_character: BoolProperty(
        name="Only This Character", description="List only the takes of the chosen character", default=True
    )
    take_index: IntProperty(
        name="Take",
        description="Active take; click one to show it on the character",
        get=_get_take,
        set=_set_take,
    )
    auto_follow: BoolProperty(
        name="Auto Follow",
        description="Generate the active take again whenever its target, a goal or a way-point was dragged",
    )
    show_trails: BoolProperty(
        name="Trails",
        description="Draw the ways of pelvis and feet of the active take; where feet slide they are red",
    )
    steps: CollectionProperty(type=SAMP_PG_step)
    step_index: IntProperty(name="Step", default=0)
    cast: CollectionProperty(type=SAMP_PG_member)
    cast_index: IntProperty(name="Character", default=0)
    farm: PointerProperty(type=SAMP_PG_farm)
    sub_goal: PointerProperty(
        name="Sub-goal",
        description="Active sub-goal, where no arrow is selected",
        type=bpy.types.Object,
        poll=_is_sub_goal,
    )
    sub_goal_index: IntProperty(
        name="Sub-goal",
        description="Active sub-goal; click one to select its arrow",
        get=sub_goal_settings.index,
        set=sub_goal_settings.set_index,
    )


CLASSES = (SAMP_PG_step, SAMP_PG_member, SAMP_PG_farm, SAMP_PG_settings)
_OWN = dict(SAMP_PG_settings.__annotations__)


def register() -> None:
    """Add the settings to scenes, with the options of the methods that are there now."""
    SAMP_PG_settings.__annotations__ = _OWN | measures.annotations() | method_options.annotations()
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.samp = PointerProperty(type=SAMP_PG_settings)


def unregister() -> None:
    """Remove the settings from scenes."""
    del bpy.types.Scene.samp
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
