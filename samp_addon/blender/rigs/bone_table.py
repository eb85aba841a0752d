"""The bone table of an armature: joint to bone, edited by the artist and saved with the file."""

from __future__ import annotations

import bpy
from bpy.props import CollectionProperty, IntProperty, StringProperty

from ...errors import SampError

TABLE, ACTIVE = "samp_rig_map", "samp_rig_map_index"
"""The properties of an armature object that hold the table and its active row."""


class SAMP_RigMapEntry(bpy.types.PropertyGroup):
    """A row of the table: a joint and its bone."""

    joint: StringProperty(name="Joint", description="SMPL-X name of the joint")
    bone: StringProperty(
        name="Bone", description="Bone of this armature that corresponds to the joint; may be empty"
    )


def register() -> None:
    """Add the table to objects."""
    bpy.utils.register_class(SAMP_RigMapEntry)
    shared = {"override": {"LIBRARY_OVERRIDABLE"}}
    setattr(bpy.types.Object, TABLE, CollectionProperty(name="Bone Table", type=SAMP_RigMapEntry, **shared))
    setattr(bpy.types.Object, ACTIVE, IntProperty(name="Active Row", options={"HIDDEN"}, **shared))


def unregister() -> None:
    """Remove the table from objects; its data stays in the file."""
    delattr(bpy.types.Object, ACTIVE)
    delattr(bpy.types.Object, TABLE)
    bpy.utils.unregister_class(SAMP_RigMapEntry)


def read(armature: bpy.types.Object) -> dict[str, str]:
    """Return joint -> bone of the filled rows; empty if the extension is not registered."""
    return {row.joint: row.bone for row in getattr(armature, TABLE, ()) if row.bone}


def fill(armature: bpy.types.Object, bones: dict[str, str], keep: bool = True) -> None:
    """Fill the table with joint -> bone, one row for each joint that can be carried.

    keep: rows that name a bone of the armature do not change. Raise SampError where the armature cannot be edited.
    """
    from ...rigs import maps

    if not armature.is_editable:
        raise SampError(
            f"'{armature.name}' is linked from another file; make a library override of it first."
        )
    kept = (
        {joint: bone for joint, bone in read(armature).items() if bone in armature.data.bones} if keep else {}
    )
    used = set(kept.values())
    table = getattr(armature, TABLE)
    table.clear()
    for joint in maps.JOINTS:
        row = table.add()
        guessed = bones.get(joint, "")
        row.name = row.joint = joint
        row.bone = kept.get(joint, "" if guessed in used else guessed)
