"""What the artist has set in the sidebar, saved with the scene (``scene.samp``)."""

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
)

from . import method_options

ACTIONS = (
    ("sit", "Sit", "Walk to the target and sit down"),
    ("lie", "Lie", "Walk to the target and lie down"),
    ("walk", "Walk", "Walk to the target, or to the 3D cursor"),
    ("run", "Run", "Run to the target, or to the 3D cursor"),
)
SHAPES = ("male", "female", "tall", "short", "heavy", "thin", "muscular", "elder")


def _is_character(settings: bpy.types.PropertyGroup, thing: bpy.types.Object) -> bool:
    if thing.type != "ARMATURE":
        return False
    from ..blender.character import armature

    return armature.is_smplx(thing)


def _is_no_character(settings: bpy.types.PropertyGroup, thing: bpy.types.Object) -> bool:
    return thing.type not in {"ARMATURE", "CAMERA", "LIGHT", "SPEAKER"}


def _owner(settings: bpy.types.PropertyGroup) -> bpy.types.Object | None:
    """The character whose takes the list shows, without a look at all objects."""
    if settings.character is not None:
        return settings.character
    active = bpy.context.view_layer.objects.active
    return active if active is not None and active.type == "ARMATURE" else None


def _shown_take(settings: bpy.types.PropertyGroup) -> int:
    """The number among all Actions of the one that the character plays; -1 where there is none."""
    owner = _owner(settings)
    action = owner.animation_data.action if owner is not None and owner.animation_data else None
    return -1 if action is None else bpy.data.actions.find(action.name)


def _show_take(settings: bpy.types.PropertyGroup, number: int) -> None:
    """A click on a take in the list shows it on the character."""
    from ..blender.character import armature
    from ..blender.takes import take_list
    from ..errors import SampError
    from . import job_from_settings

    actions = bpy.data.actions
    if not 0 <= number < len(actions) or not take_list.is_take(actions[number]):
        return
    try:
        owner = armature.find(bpy.context, job_from_settings.character_name(settings))
        take_list.show(bpy.context, owner, actions[number])
    except SampError:
        # The character may be linked, or gone: then there is nobody to show the take on.
        return


class SAMP_PG_step(bpy.types.PropertyGroup):
    """One step of a chain."""

    action: EnumProperty(name="Action", items=ACTIONS)
    target: PointerProperty(
        name="Target", description="The furniture", type=bpy.types.Object, poll=_is_no_character
    )
    place: FloatVectorProperty(
        name="Place", description="Where to go without a target", subtype="TRANSLATION"
    )


class SAMP_PG_settings(bpy.types.PropertyGroup):
    """The sidebar's own settings of a scene."""

    character: PointerProperty(
        name="Character",
        description="SMPL-X armature; empty: the selected one, the only one, or a new human",
        type=bpy.types.Object,
        poll=_is_character,
    )
    shape: FloatVectorProperty(
        name="Shape", description="Of the next character that is created", size=len(SHAPES), min=0.0, max=1.0
    )
    method: EnumProperty(name="Method", description="How the motion is made", items=method_options.items)
    action: EnumProperty(name="Action", description="What the character does", items=ACTIONS)
    target: PointerProperty(
        name="Target",
        description="The furniture; empty: the active object",
        type=bpy.types.Object,
        poll=_is_no_character,
    )
    seed: IntProperty(
        name="Seed", description="Another seed gives another take; each press goes on to the next", min=0
    )
    variants: IntProperty(name="Takes", description="How many at once", default=1, min=1, max=64)
    style: FloatProperty(
        name="Style",
        description="How much takes differ from each other",
        default=0.1,
        min=0.0,
        max=1.0,
        soft_max=0.4,
        step=1,
    )
    hold: FloatProperty(
        name="Hold",
        description="Seconds at the end",
        default=2.0,
        min=0.0,
        max=600.0,
        subtype="TIME_ABSOLUTE",
    )
    speed: FloatProperty(
        name="Speed", description="Of the motion beside people's own", default=1.0, min=0.5, max=2.0, step=5
    )
    refine: BoolProperty(
        name="Refine", description="Mend contact, penetration and foot slide of each take; takes longer"
    )
    fit_range: BoolProperty(
        name="Fit Frame Range",
        description="Move the scene's end so that a longer take plays whole",
        default=True,
    )
    take_index: IntProperty(
        name="Take", description="Click a take to see it", get=_shown_take, set=_show_take
    )
    steps: CollectionProperty(type=SAMP_PG_step)
    step_index: IntProperty(name="Step", default=0)


SAMP_PG_settings.__annotations__.update(method_options.annotations())

CLASSES = (SAMP_PG_step, SAMP_PG_settings)


def add_to_scenes() -> None:
    """Gives every scene its settings."""
    bpy.types.Scene.samp = PointerProperty(type=SAMP_PG_settings)


def take_from_scenes() -> None:
    """Undoes add_to_scenes."""
    del bpy.types.Scene.samp
