"""Runs an operator's work and reports its outcome; poll conditions that operators share."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..samp_addon import dependencies
from ..samp_addon.errors import SampError


def run(
    operator: bpy.types.Operator, work: Callable[[], str], finished: set[str] = frozenset({"FINISHED"})
) -> set[str]:
    """Do the work and report the message that it returns, or the error that it raises for the artist.

    finished: what the operator returns on success. An empty message is not reported.
    """
    try:
        message = work()
    except SampError as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    except (ImportError, OSError) as error:
        message = dependencies.explain(error)
        if message is None:
            raise
        operator.report({"ERROR"}, message)
        return {"CANCELLED"}
    if message:
        operator.report({"INFO"}, message)
    return set(finished)


def in_object_or_pose_mode(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Return whether Object or Pose Mode is active; otherwise the operator's tooltip gives the reason."""
    if context.mode not in {"OBJECT", "POSE"}:
        operator.poll_message_set("Go to Object or Pose Mode first")
        return False
    return True


def has_character(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Return whether the mode fits and the scene has an SMPL-X armature; otherwise the tooltip gives the reason."""
    from ..samp_addon.blender.character import armature

    if not in_object_or_pose_mode(operator, context):
        return False
    if not any(armature.is_smplx(obj) for obj in context.scene.objects):
        operator.poll_message_set("The scene has no SMPL-X armature; create a character first")
        return False
    return True


def has_action(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Return whether there are a character and an Action to work on; otherwise the tooltip gives the reason."""
    if not has_character(operator, context):
        return False
    if not bpy.data.actions:
        operator.poll_message_set("The character has no Action; generate a take first")
        return False
    return True


def in_object_mode(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Return whether Object Mode is active; otherwise the operator's tooltip gives the reason."""
    if context.mode != "OBJECT":
        operator.poll_message_set("Go to Object Mode first")
        return False
    return True


def other_object(context: bpy.types.Context, owner: bpy.types.Object, name: str = "") -> bpy.types.Object:
    """Return the object of this name, or the selected one that is no part of the owner. Raise SampError without one."""
    if name:
        found = context.scene.objects.get(name)
        if found is None:
            raise SampError(f"There is no '{name}' in the scene; name an object that is there.")
        return found
    others = [obj for obj in context.selected_objects if owner not in (obj, obj.parent)]
    if not others:
        raise SampError("Nothing else is selected; select the target, then the character.")
    return others[0]
