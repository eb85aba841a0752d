"""Finds, checks and calibrates SMPL-X armatures.

The two public SMPL-X add-ons create different armatures (metres, Z up; centimetres, Y up on a rotated object). No
convention is assumed: axes, scale and proportions are read from the armature's rest bones.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames, rotation, skeleton
from ...errors import SampError
from ...motion import Motion

# Other names of the same joint.
ALIASES = {"left_eye_smplhf": ("left_eye",), "right_eye_smplhf": ("right_eye",)}
# Matrix entries nearer than this to whole axes are snapped to them.
_SNAP = 0.06
# Degrees by which body shape may turn an arm or a leg from the T-pose; more is another rest pose.
_MAX_BEND = 30.0


@dataclass(frozen=True, eq=False)
class Calibration:
    """Relation of an armature to the network's skeleton.

    bones: the bone of each of the 55 joints, or None. ancestors: bones above the
    pelvis. axes: (3, 3) rotates network axes to the armature's own. bases: (55, 3, 3) rest rotation of each
    bone in the armature's axes. world: (4, 4) of the object; turn: (3, 3) its rotation; scale: metres of
    the world per unit. pelvis_head: (3,) in the armature's units. rest_joints: (55, 3) metres of the
    world, network frame, pelvis at the origin.
    """

    bones: tuple[str | None, ...]
    ancestors: tuple[str, ...]
    axes: np.ndarray
    bases: np.ndarray
    world: np.ndarray
    turn: np.ndarray
    scale: float
    pelvis_head: np.ndarray
    rest_joints: np.ndarray


CONTROLS_KEY = "samp_controls"
"""Custom property of the objects of a control rig, see blender/controls/rig.py."""


def bone_name(armature: bpy.types.Object, joint: str) -> str | None:
    """Return the armature's bone for an SMPL-X joint, or None."""
    names = (joint, *ALIASES.get(joint, ()))
    return next((name for name in names if name in armature.data.bones), None)


def missing_bones(armature: bpy.types.Object) -> list[str]:
    """Return the body joints (of 22) for which the armature has no bone."""
    return [joint for joint in skeleton.BODY_JOINTS if bone_name(armature, joint) is None]


def is_smplx(obj: bpy.types.Object | None) -> bool:
    """Return whether the object is an armature with the 22 SMPL-X body bones, and no control rig of another one."""
    return obj is not None and obj.type == "ARMATURE" and CONTROLS_KEY not in obj and not missing_bones(obj)


def find(context: bpy.types.Context, name: str = "") -> bpy.types.Object:
    """Return the SMPL-X armature of this name, or the active one, the active mesh's, or the scene's only one.

    Raise SampError where there is none, or several and none of them is active.
    """
    if name:
        named = context.scene.objects.get(name)
        if named is None:
            raise SampError(f"The scene has no object '{name}'; name an SMPL-X armature that is in it.")
        owner = _armature_of(named)
        if owner is None:
            raise SampError(f"'{name}' is not an armature; name an SMPL-X armature, or create a character.")
        check(owner)
        return owner
    active = _armature_of(context.view_layer.objects.active)
    if active is not None:
        check(active)
        return active
    present = [obj for obj in context.scene.objects if is_smplx(obj)]
    if len(present) == 1:
        return present[0]
    if present:
        names = ", ".join(f"'{obj.name}'" for obj in present)
        raise SampError(f"The scene has several characters ({names}); select one of them.")
    raise SampError("The scene has no SMPL-X armature; create a character first.")


def _armature_of(obj: bpy.types.Object | None) -> bpy.types.Object | None:
    """Return the object itself, or the armature that deforms it."""
    if obj is None or obj.type == "ARMATURE":
        return obj
    return obj.find_armature()


def check(armature: bpy.types.Object) -> None:
    """Raise SampError, naming the bones, where the armature is not an SMPL-X armature."""
    missing = missing_bones(armature)
    if missing:
        raise SampError(
            f"'{armature.name}' is not an SMPL-X armature: it lacks the bones {', '.join(missing)}; "
            "choose an SMPL-X armature or create a character."
        )
    for j, joint in enumerate(skeleton.BODY_JOINTS):
        bone = armature.data.bones[bone_name(armature, joint)]
        above = {parent.name for parent in bone.parent_recursive}
        if j and bone_name(armature, skeleton.JOINTS[skeleton.PARENTS[j]]) not in above:
            wanted = skeleton.JOINTS[skeleton.PARENTS[j]]
            raise SampError(
                f"Bone '{joint}' of '{armature.name}' is not a child of '{wanted}'; parent it there."
            )
        if bone.parent is not None and not bone.use_inherit_rotation:
            raise SampError(
                f"Bone '{joint}' of '{armature.name}' does not inherit rotation; turn on Inherit Rotation."
            )
    pelvis = armature.data.bones["pelvis"]
    if pelvis.use_connect or not pelvis.use_local_location:
        raise SampError(
            f"Bone 'pelvis' of '{armature.name}' cannot move; turn off Connected and turn on Local Location."
        )


def calibrate(armature: bpy.types.Object) -> Calibration:
    """Measure an SMPL-X armature in its rest pose, with its object where it is now.

    Raise SampError for another rig, a rest pose that is not SMPL-X's T-pose, and a scale that differs by
    axis.
    """
    check(armature)
    bpy.context.view_layer.update()  # matrix_world is stale after a script moved the object
    bones = tuple(bone_name(armature, joint) for joint in skeleton.JOINTS)
    data = [armature.data.bones[name] if name else None for name in bones]
    heads = np.array([bone.head_local if bone else (np.nan,) * 3 for bone in data], dtype=np.float64)
    bases = np.array([np.array(bone.matrix_local.to_3x3()) if bone else np.eye(3) for bone in data])
    world = np.array(armature.matrix_world, dtype=np.float64)
    turn, scale = turn_and_scale(armature.name, world)
    axes = _axes(armature.name, heads[: skeleton.BODY_COUNT])
    rest = (heads - heads[0]) @ axes * scale
    return Calibration(
        bones=bones,
        ancestors=tuple(bone.name for bone in data[0].parent_recursive),
        axes=axes,
        bases=orthonormal(bases),
        world=world,
        turn=turn,
        scale=scale,
        pelvis_head=heads[0],
        rest_joints=_fill_missing(rest),
    )


def orthonormal(matrices: np.ndarray) -> np.ndarray:
    """Return the nearest rotations (..., 3, 3); Blender's float32 matrices are only approximately orthonormal."""
    u, _, vt = np.linalg.svd(matrices)
    return u @ vt


def turn_and_scale(name: str, world: np.ndarray) -> tuple[np.ndarray, float]:
    """Return rotation (3, 3) and uniform scale of an object's matrix (4, 4)."""
    lengths = np.linalg.norm(world[:3, :3], axis=0)
    scale = float(lengths.mean())
    if scale < 1e-9 or not np.isfinite(world).all():
        raise SampError(f"'{name}' has a scale of zero; give it a scale.")
    turn = world[:3, :3] / scale
    if np.abs(turn.T @ turn - np.eye(3)).max() > 1e-3 or np.linalg.det(turn) < 0:
        raise SampError(
            f"'{name}' has a scale that differs by axis or mirrors it; apply its scale (Ctrl+A) first."
        )
    return orthonormal(turn), scale


def _axes(name: str, heads: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) of network axes to the armature's own, from its rest joints (22, 3).

    Proportions bias the best fit by a degree or two, so it is snapped: to whole axes if near, else only the up
    axis, with the side axis from the pairs of left and right joints (a rotation that was applied to the rest pose).
    """
    ours = skeleton.default_rest_joints()[: skeleton.BODY_COUNT]
    u, _, vt = np.linalg.svd((heads - heads.mean(0)).T @ (ours - ours.mean(0)))
    fit = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    axes = np.round(fit)
    if np.abs(fit - axes).max() > _SNAP:
        up = np.round(fit[:, 1]) if np.abs(fit[:, 1] - np.round(fit[:, 1])).max() < _SNAP else fit[:, 1]
        left = [skeleton.INDEX[joint] for joint in skeleton.BODY_JOINTS if joint.startswith("left_")]
        right = [skeleton.mirror_joints()[j] for j in left]
        side = (heads[left] - heads[right]).sum(0)
        side -= (side @ up) * up
        side /= np.linalg.norm(side)
        axes = np.stack([side, up, np.cross(side, up)], axis=1)
    bent = _angles((heads - heads[0]) @ axes, ours)
    if bent.max() > _MAX_BEND:
        joint = skeleton.BODY_JOINTS[int(np.argmax(bent))]
        raise SampError(
            f"The rest pose of '{name}' is not SMPL-X's T-pose (at '{joint}'); make the T-pose its rest pose."
        )
    return axes


def _angles(own: np.ndarray, ours: np.ndarray) -> np.ndarray:
    """Return angles (22,) in degrees between long bones (arms and legs) of two skeletons; 0 for other bones."""
    result = np.zeros(skeleton.BODY_COUNT)
    for joint in ("knee", "ankle", "elbow", "wrist"):
        for side in ("left", "right"):
            j = skeleton.INDEX[f"{side}_{joint}"]
            a, b = own[j] - own[skeleton.PARENTS[j]], ours[j] - ours[skeleton.PARENTS[j]]
            cosine = a @ b / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-12)
            result[j] = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return result


def _fill_missing(rest: np.ndarray) -> np.ndarray:
    """Return rest joints with missing ones set by the default skeleton's offsets from their parents."""
    ours = skeleton.default_rest_joints()
    rest = rest.copy()
    for j in range(1, len(rest)):
        if np.isnan(rest[j]).any():
            rest[j] = rest[skeleton.PARENTS[j]] + ours[j] - ours[skeleton.PARENTS[j]]
    return rest


def standing_place(armature: bpy.types.Object) -> tuple[np.ndarray, float]:
    """Return where the character stands: pelvis joint (3,), metres, and yaw, radians, network frame."""
    calibration = calibrate(armature)
    pose = np.array(armature.matrix_world @ armature.pose.bones["pelvis"].matrix, dtype=np.float64)
    forward = (
        orthonormal(pose[:3, :3]) @ calibration.bases[0].T @ calibration.axes @ np.array([0.0, 0.0, 1.0])
    )
    direction = frames.to_network(forward)
    return frames.to_network(pose[:3, 3]), float(frames.direction_yaw(direction))


def standing_floor(armature: bpy.types.Object) -> tuple[np.ndarray, float]:
    """Return the floor (3,), metres, on which the character stands, and its yaw, radians; network frame."""
    pelvis, yaw = standing_place(armature)
    return pelvis + [0.0, calibrate(armature).rest_joints[:, 1].min(), 0.0], yaw


def posed(armature: bpy.types.Object) -> Motion:
    """Return the pose that Blender shows now, as a Motion of one frame in the armature's proportions."""
    calibration, pose = calibrate(armature), armature.pose.bones
    world = np.array(armature.matrix_world, dtype=np.float64)
    whole = np.tile(np.eye(3), (len(skeleton.JOINTS), 1, 1))
    for j, bone in enumerate(calibration.bones):
        if bone is None:
            whole[j] = whole[skeleton.PARENTS[j]]
            continue
        shown = orthonormal((world @ np.array(pose[bone].matrix, dtype=np.float64))[:3, :3])
        whole[j] = frames.NETWORK_FROM_BLENDER @ shown @ calibration.bases[j].T @ calibration.axes
    local = whole.copy()
    for j in range(1, len(whole)):
        local[j] = whole[skeleton.PARENTS[j]].T @ whole[j]
    head = (world @ np.append(np.array(pose[calibration.bones[0]].head, dtype=np.float64), 1.0))[:3]
    return Motion(
        frames.to_network(head)[None],
        rotation.matrix_to_quaternion(local)[None],
        rest_joints=calibration.rest_joints,
    )
