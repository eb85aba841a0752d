"""The control rig of the default human: a second armature that follows the first, with IK to empties.

The character plays its takes as before. The control rig is an armature object with the same bones that copies the
character's pose and deforms its mesh. IK pulls each hand and foot of the rig to an empty that is a child of the
character's own hand or foot. While the empty is not moved, the limb is where the take has it, in every take; a moved or
keyed empty is a layer above the take. Of the character only its meshes' modifiers change, and `remove` restores them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...errors import SampError
from ..character import armature
from ..scene.candidates import OVERLAY_KEY

KEY = armature.CONTROLS_KEY
SHOWN = "samp_shown"
"""Custom property of a mesh: whether its own Armature modifier was shown in the viewport and in renders."""
NAME = "SAMP Controls"
"""Name of the constraints and modifiers."""
POLE_AWAY = 0.5
"""Metres from a shoulder or hip to its pole."""
TOUCHES = 1e-4
"""Metres between the end of a forearm or shin and the next joint within which IK to that joint changes nothing."""


class Limb(NamedTuple):
    """A limb with IK. upper, lower, end: its joints from the trunk outwards. pole: direction from the upper joint to
    the pole, in the armature's axes."""

    name: str
    upper: str
    lower: str
    end: str
    pole: tuple[float, float, float]


FORWARD, BACK = (0.0, -1.0, 0.0), (0.0, 1.0, 0.0)
LIMBS = tuple(
    limb
    for side in ("left", "right")
    for limb in (
        Limb(f"{side} hand", f"{side}_shoulder", f"{side}_elbow", f"{side}_wrist", BACK),
        Limb(f"{side} foot", f"{side}_hip", f"{side}_knee", f"{side}_ankle", FORWARD),
    )
)


def find(owner: bpy.types.Object) -> bpy.types.Object | None:
    """Return the armature object of a character's control rig, or None."""
    return next((obj for obj in owner.children if KEY in obj and obj.type == "ARMATURE"), None)


def controls(owner: bpy.types.Object) -> list[bpy.types.Object]:
    """Return the empties of a character's control rig."""
    return [obj for obj in owner.children if KEY in obj and obj.type == "EMPTY"]


def character(context: bpy.types.Context, name: str = "") -> bpy.types.Object:
    """Return the named character. Without a name: that of the active control, or what armature.find returns."""
    active = context.view_layer.objects.active
    if not name and active is not None and KEY in active and active.parent is not None:
        return active.parent
    return armature.find(context, name)


def add(context: bpy.types.Context, owner: bpy.types.Object) -> bpy.types.Object:
    """Add a control rig to a human and return its armature object.

    Raise SampError where there is one already, where forearms and shins do not end in the next joint, and for a
    character that is linked from another file.
    """
    armature.check(owner)
    if find(owner) is not None:
        raise SampError(f"'{owner.name}' has a control rig already; remove it first.")
    _require_joined(owner)
    if not owner.is_editable:
        raise SampError(f"'{owner.name}' is linked from another file; make it local or an override first.")
    rig = _object(owner, f"{owner.name} control rig", owner.data)
    context.view_layer.update()  # makes its pose; hidden objects have none at first
    rig.hide_viewport = rig.hide_render = True
    for bone in rig.pose.bones:
        copied = bone.constraints.new("COPY_TRANSFORMS")
        copied.name, copied.target, copied.subtarget = NAME, owner, bone.name
        copied.owner_space = copied.target_space = "LOCAL"
    for limb in LIMBS:
        _add_limb(owner, rig, limb)
    for mesh in _meshes(owner):
        _deform_by(mesh, owner, rig)
    context.view_layer.update()
    return rig


def remove(context: bpy.types.Context, owner: bpy.types.Object) -> None:
    """Remove a control rig and restore the modifiers of the character's meshes. Raise SampError where there is none."""
    rig = find(owner)
    if rig is None:
        raise SampError(f"'{owner.name}' has no control rig; there is nothing to remove.")
    for mesh in _meshes(owner):
        for modifier in list(mesh.modifiers):
            if modifier.type == "ARMATURE" and modifier.object == rig:
                mesh.modifiers.remove(modifier)
        own = _own_modifier(mesh, owner)
        if own is not None and SHOWN in mesh:
            own.show_viewport, own.show_render = (bool(shown) for shown in mesh[SHOWN])
            del mesh[SHOWN]
    for obj in (rig, *controls(owner)):
        action = obj.animation_data.action if obj.animation_data is not None else None
        bpy.data.objects.remove(obj)
        if action is not None and not action.users:
            bpy.data.actions.remove(action)
    context.view_layer.update()


def _object(owner: bpy.types.Object, name: str, data: bpy.types.ID | None) -> bpy.types.Object:
    """Return a new object of the rig: a child of the character, in the character's collections."""
    made = bpy.data.objects.new(name, data)
    made[OVERLAY_KEY] = made[KEY] = True
    made.parent = owner
    for collection in owner.users_collection:
        collection.objects.link(made)
    return made


def _add_limb(owner: bpy.types.Object, rig: bpy.types.Object, limb: Limb) -> None:
    """Add the control and the pole of a hand or foot, and the constraints of the rig that follow them."""
    upper, lower, end = (armature.bone_name(owner, name) for name in (limb.upper, limb.lower, limb.end))
    control = _object(owner, f"{owner.name} {limb.name}", None)
    control.empty_display_type, control.empty_display_size = "CUBE", 0.06
    _hang(control, owner, end, Vector())
    pole = _object(owner, f"{owner.name} {limb.name} pole", None)
    pole.empty_display_type, pole.empty_display_size = "SPHERE", 0.04
    bone = owner.data.bones[upper]
    # IK turns the limb until this direction of the upper bone points to the pole. The pole lies there already.
    out = bone.matrix_local.to_3x3().inverted() @ Vector(limb.pole)
    angle = math.atan2(out.z, out.x)
    scale = max(armature.calibrate(owner).scale, 1e-9)
    _hang(pole, owner, upper, Vector((math.cos(angle), 0.0, math.sin(angle))) * (POLE_AWAY / scale))
    for shown in (control, pole):
        shown.show_in_front = True
    pull = rig.pose.bones[lower].constraints.new("IK")
    pull.name, pull.target, pull.pole_target, pull.pole_angle = NAME, control, pole, angle
    pull.chain_count, pull.use_stretch = 2, False
    turned = rig.pose.bones[end].constraints.new("COPY_ROTATION")
    turned.name, turned.target = NAME, control


def _hang(obj: bpy.types.Object, owner: bpy.types.Object, bone: str, place: Vector) -> None:
    """Make an object a child of a bone, so that without a transform of its own it is at ``place``.

    place: in the bone's axes, from its head, in the armature's units.
    """
    obj.parent_type, obj.parent_bone = "BONE", bone
    # Children of a bone are relative to its tail.
    length = owner.data.bones[bone].length
    obj.matrix_parent_inverse = Matrix.Translation(place - Vector((0.0, length, 0.0)))


def _deform_by(mesh: bpy.types.Object, owner: bpy.types.Object, rig: bpy.types.Object) -> None:
    """Let the rig deform a mesh in place of the character.

    The character's own modifier is turned off and stays last: Blender takes the mesh as that armature's.
    """
    own = _own_modifier(mesh, owner)
    if own is None:
        return
    made = mesh.modifiers.new(NAME, "ARMATURE")
    made.object = rig
    for name in ("use_deform_preserve_volume", "use_vertex_groups", "use_bone_envelopes", "vertex_group"):
        setattr(made, name, getattr(own, name))
    mesh.modifiers.move(len(mesh.modifiers) - 1, list(mesh.modifiers).index(own))
    mesh[SHOWN] = [own.show_viewport, own.show_render]
    own.show_viewport = own.show_render = False


def _own_modifier(mesh: bpy.types.Object, owner: bpy.types.Object) -> bpy.types.Modifier | None:
    """Return the Armature modifier by which a character deforms a mesh, or None."""
    return next((m for m in mesh.modifiers if m.type == "ARMATURE" and m.object == owner), None)


def _meshes(owner: bpy.types.Object) -> list[bpy.types.Object]:
    """Return the meshes that a character deforms."""
    return [obj for obj in bpy.data.objects if obj.type == "MESH" and _own_modifier(obj, owner) is not None]


def _require_joined(owner: bpy.types.Object) -> None:
    """Raise SampError where a forearm or shin does not end in the next joint: IK would move the hand or foot there."""
    for limb in LIMBS:
        names = [armature.bone_name(owner, name) for name in (limb.lower, limb.end)]
        lower, end = (owner.data.bones[name] for name in names)
        apart = np.linalg.norm(np.array(lower.tail_local) - np.array(end.head_local))
        if apart > TOUCHES:
            raise SampError(
                f"Bone '{lower.name}' of '{owner.name}' does not end in '{end.name}'; the control rig is for humans "
                "that Create Character made."
            )
