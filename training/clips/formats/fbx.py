"""FBX files, through Blender's own importer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....samp_addon import frames, rotation
from ....samp_addon.errors import SampError
from ..recording import Recording


def read(path: Path) -> Recording:
    """Return the motion of the armature in an .fbx file, of several the one with the most bones.

    Replaces the open scene. Raise SampError where Blender cannot read the file, or it has no animated armature.
    """
    import bpy

    from ....samp_addon.blender import compat

    bpy.ops.wm.read_factory_settings(use_empty=True)
    try:
        compat.import_fbx(str(path))
    except (RuntimeError, AttributeError) as error:
        raise SampError(f"Blender cannot read '{path.name}': {str(error).strip().splitlines()[0]}") from error
    rigs = [thing for thing in bpy.context.scene.objects if thing.type == "ARMATURE"]
    rigs = [rig for rig in rigs if _action(rig) is not None]
    if not rigs:
        raise SampError(f"'{path.name}' has no animated armature.")
    rig = max(rigs, key=lambda one: len(one.data.bones))
    _disconnect(rig)
    return _sampled(rig, path.stem)


def _disconnect(rig) -> None:
    """Disconnect all bones from their parents' tails.

    The importer connects a bone whose head is at its parent's tail, and a connected bone ignores location keys.
    """
    import bpy

    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in rig.data.edit_bones:
        bone.use_connect = False
    bpy.ops.object.mode_set(mode="OBJECT")


def _action(rig):  # noqa: ANN202 - bpy is imported inside functions only
    return rig.animation_data.action if rig.animation_data else None


def _sampled(rig, name: str) -> Recording:
    import bpy

    scene = bpy.context.scene
    start, stop = (int(round(frame)) for frame in _action(rig).frame_range)
    fps = scene.render.fps / scene.render.fps_base
    bones = _parents_first(rig.data.bones)
    count = stop - start + 1
    if count < 2:
        raise SampError(f"'{name}' contains a single pose.")
    world = np.empty((count, 4, 4))
    pose = np.empty((count, len(bones), 4, 4))
    for k in range(count):
        scene.frame_set(start + k)
        shown = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
        world[k] = shown.matrix_world
        for j, bone in enumerate(bones):
            pose[k, j] = shown.pose.bones[bone.name].matrix
    # The rest pose uses the object's axes in the first frame: the file may animate the object itself.
    rest = world[0] @ np.array([bone.matrix_local for bone in bones], dtype=np.float64)
    tips = np.array([world[0] @ [*bone.tail_local, 1.0] for bone in bones])[:, :3]
    placed = world[:, None] @ pose
    turn = frames.NETWORK_FROM_BLENDER
    names = [bone.name for bone in bones]
    parents = [names.index(bone.parent.name) if bone.parent else -1 for bone in bones]
    return Recording(
        name, fps, tuple(names), np.array(parents),
        frames.to_network(rest[:, :3, 3]), frames.to_network(tips), frames.to_network(placed[..., :3, 3]),
        rotation.matrix_to_quaternion(turn @ _rotations(placed)),
        rotation.matrix_to_quaternion(turn @ _rotations(rest)),
    )  # fmt: skip


def _rotations(matrices: np.ndarray) -> np.ndarray:
    """Return the rotations (..., 3, 3) of matrices (..., 4, 4), scale removed."""
    axes = matrices[..., :3, :3]
    return axes / np.linalg.norm(axes, axis=-2, keepdims=True)


def _parents_first(bones) -> list:
    """Return all bones, parents before children."""
    return sorted(bones, key=lambda bone: len(bone.parent_recursive))
