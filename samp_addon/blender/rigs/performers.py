"""Who plays a take: an SMPL-X armature, or a rig of another kind onto which takes are carried as they are written.

For such a rig a take is made for the default human, and retargeted.
"""

from __future__ import annotations

import bpy
import numpy as np

from ... import frames
from ...body import human
from ...body.human import Human
from ...errors import SampError
from ...motion import Motion
from ..actions import keyframes
from ..character import armature, character
from . import bone_table

# Retargeting needs packages that Blender does not ship: it is imported where a rig is met.


def is_rig(obj: bpy.types.Object | None) -> bool:
    """Return whether an object is the armature of a body of another kind: of known bones, or with a bone table."""
    if obj is None or obj.type != "ARMATURE" or armature.is_smplx(obj):
        return False
    from ...rigs import maps

    return bool(bone_table.read(obj)) or maps.recognise(bone.name for bone in obj.data.bones) is not None


def is_performer(obj: bpy.types.Object | None) -> bool:
    """Return whether an object can play takes."""
    return armature.is_smplx(obj) or is_rig(obj)


def find(context: bpy.types.Context, name: str = "") -> bpy.types.Object:
    """Return the performer of this name, or, without one, what `armature.find` returns. Raise SampError."""
    named = context.scene.objects.get(name) if name else None
    if named is not None:
        owner = named if named.type == "ARMATURE" else named.find_armature()
        if is_rig(owner):
            return owner
    return armature.find(context, name)


def standing_floor(owner: bpy.types.Object) -> tuple[np.ndarray, float]:
    """Return the floor (3,), metres, on which a performer stands, and its yaw, radians; network frame."""
    if not is_rig(owner):
        return armature.standing_floor(owner)
    pelvis, yaw = pelvis_of(owner)
    return np.array([pelvis[0], _rest_heights(owner).min(), pelvis[2]]), yaw


def pelvis_of(rig: bpy.types.Object) -> tuple[np.ndarray, float]:
    """Return where the pelvis bone of a rig is now (3,), metres, and the yaw of its hips, radians; network frame."""
    from . import carry_to_rig

    _, bones = carry_to_rig.bones_of(rig)
    world = np.array(rig.matrix_world, dtype=np.float64)
    head = lambda joint: frames.to_network(
        (world @ np.append(np.array(rig.pose.bones[bones[joint]].head, dtype=np.float64), 1.0))[:3]
    )
    across = head("left_hip") - head("right_hip")
    return head("pelvis"), float(np.arctan2(-across[2], across[0]))


def body_of(owner: bpy.types.Object | None) -> Human:
    """Return the body for which takes are made: the performer's own, the default human for rigs and for None."""
    return human.load() if owner is None or is_rig(owner) else character.body_of(owner)


def shapes_of(owner: bpy.types.Object) -> dict[str, float]:
    """Return the weights of the body's shapes; see character.shapes_of."""
    return {} if is_rig(owner) else character.shapes_of(owner)


def height(owner: bpy.types.Object) -> float:
    """Return the height of the rest pose in units of the scene."""
    if not is_rig(owner):
        return float(np.ptp(armature.calibrate(owner).rest_joints[:, 1]))
    return float(np.ptp(_rest_heights(owner)))


def _rest_heights(rig: bpy.types.Object) -> np.ndarray:
    """Return the world heights (2 B,) of the heads and tails of the rest bones."""
    world = np.array(rig.matrix_world, dtype=np.float64)
    ends = [end for bone in rig.data.bones for end in (bone.head_local, bone.tail_local)]
    return np.array(ends, dtype=np.float64) @ world[2, :3] + world[2, 3]


def write(
    context: bpy.types.Context, owner: bpy.types.Object, motion: Motion, name: str, frame_start: int
) -> tuple[bpy.types.Action, list[str]]:
    """Write a motion as a new Action of a performer, which stays inactive; return it, and what is not exact.

    Raise SampError where Blender does not allow it; see keyframes.write_motion and carry_to_rig.write_take.
    """
    if not is_rig(owner):
        return keyframes.write_motion(owner, motion, name, frame_start, context.scene, False), []
    from . import carry_to_rig

    return carry_to_rig.write_take(context, owner, motion, name, frame_start)


def shown(
    context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action, motion: Motion
) -> tuple[Motion, list[str]]:
    """Return the motion that Blender shows, see seen.shown_motion; for rigs the take's own ``motion``."""
    from ..takes import seen

    return (motion, []) if is_rig(owner) else seen.shown_motion(context, owner, action)


def require_smplx(owner: bpy.types.Object | None, what: str) -> None:
    """Raise SampError where a performer is a rig, for which there is no ``what``."""
    if is_rig(owner):
        raise SampError(
            f"'{owner.name}' is not an SMPL-X armature, which {what} needs; create a character for it."
        )
