"""One member of the cast in the sidebar, saved with the scene (``scene.samp.cast``)."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    PointerProperty,
    StringProperty,
)

from ..parts.choices import is_character, is_target

ACTIONS = (
    ("sit", "Sit", "Walk to the target and sit down"),
    ("lie", "Lie", "Walk to the target and lie down"),
    ("walk", "Walk", "Walk to the target or the location"),
    ("run", "Run", "Run to the target or the location"),
)


class SAMP_PG_member(bpy.types.PropertyGroup):
    """One character of the cast."""

    name: StringProperty(name="Name", description="Name of the character that is made")
    character: PointerProperty(
        name="Character",
        description="SMPL-X armature; if empty, a new human is made",
        type=bpy.types.Object,
        poll=is_character,
    )
    action: EnumProperty(name="Action", description="Action of this character", items=ACTIONS)
    target: PointerProperty(
        name="Target",
        description="Furniture for the action; characters with the same target take different places on it",
        type=bpy.types.Object,
        poll=is_target,
    )
    place: FloatVectorProperty(
        name="Location", description="Destination if there is no target", subtype="TRANSLATION"
    )
    use_start: BoolProperty(name="Start", description="Start at a given place instead of the start marker")
    start: FloatVectorProperty(name="Start", description="Where to start", subtype="TRANSLATION")
    start_yaw: FloatProperty(
        name="Start Facing", description="Turn to the left from facing -Y, seen from above", subtype="ANGLE"
    )
    delay: FloatProperty(
        name="Delay",
        description="Time that this character waits at least before it sets off, in seconds",
        min=0.0,
        max=3600.0,
        soft_max=30.0,
        subtype="TIME_ABSOLUTE",
    )
    look_at: PointerProperty(
        name="Look At",
        description="Character or object that this character looks at in the end",
        type=bpy.types.Object,
    )
