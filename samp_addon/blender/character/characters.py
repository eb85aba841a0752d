"""The characters of a scene, which move and are therefore no furniture."""

from __future__ import annotations

import bpy

from . import armature

CARRIED = "samp_carried"
"""Custom property of a carried Action: its source, and the rig that it was carried to."""


def people(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Return the SMPL-X armatures of the scene, and the rigs that takes were carried to."""
    rigs = _carried_to()
    return [obj for obj in context.scene.objects if armature.is_smplx(obj) or _is_carried(obj, rigs)]


def is_carried_to(obj: bpy.types.Object) -> bool:
    """Return whether an object is a rig of another kind that a take was carried to."""
    return not armature.is_smplx(obj) and _is_carried(obj, _carried_to())


def _carried_to() -> set[str]:
    notes = (action[CARRIED] for action in bpy.data.actions if CARRIED in action)
    return {note.get("rig", "") for note in notes if hasattr(note, "get")}


def _is_carried(obj: bpy.types.Object, rigs: set[str]) -> bool:
    """Whether an object is an armature that a take was carried to; a renamed one shows it by its Actions."""
    if obj.type != "ARMATURE":
        return False
    data = obj.animation_data
    if obj.name in rigs or data is None:
        return obj.name in rigs
    strips = (strip.action for track in data.nla_tracks for strip in track.strips)
    return any(action is not None and CARRIED in action for action in (data.action, *strips))
