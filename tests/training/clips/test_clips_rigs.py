"""A walk carried to another program's rig, exported as FBX and imported: bones point where they did on the rig."""

from __future__ import annotations

import bpy
import humanoids
import numpy as np
import pytest
import recordings
import rigs
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.rigs import carry_to_rig
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Motion
from samp_blender.training.clips import formats, importer
from samp_blender.training.clips.mapping import mapped, places
from samp_blender.training.clips.quality import flexion
from samp_blender.training.clips.retarget import retargeted

BONES = (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))


pytestmark = pytest.mark.usefixtures("registered")


def exported(path, kind: str, motion):
    """The motion on a rig of a family, with skin, as an .fbx."""
    rigs.reset()
    owner = character.create_character(bpy.context)
    keyframes.write_motion(owner, motion)
    rig = humanoids.make(kind)
    bpy.context.view_layer.objects.active = rig
    carry_to_rig.guess_map(bpy.context)
    humanoids.dress(rig, carry_to_rig.bones_of(rig)[1])
    carry_to_rig.carry_to_rig(bpy.context, rig.name, owner.name)
    for thing in bpy.context.scene.objects:
        thing.select_set(rig in (thing, thing.parent))
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, len(motion)
    bpy.ops.export_scene.fbx(
        filepath=str(path), use_selection=True, add_leaf_bones=False, bake_anim_simplify_factor=0.0,
        bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False,
    )  # fmt: skip
    return path


def bare(path, motion):
    """The motion on an armature without skin, as an .fbx: its rest pose is the first frame's."""
    rigs.reset()
    owner = rigs.make("mpi")
    keyframes.write_motion(owner, motion)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, len(motion)
    bpy.context.scene.frame_set(1)
    bpy.ops.export_scene.fbx(
        filepath=str(path), object_types={"ARMATURE"}, add_leaf_bones=False, bake_anim_simplify_factor=0.0,
        bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False,
    )  # fmt: skip
    return path


def directions(positions: np.ndarray, at) -> np.ndarray:
    """Unit vectors (T, 8, 3) along the limbs' bones."""
    ways = np.stack(
        [positions[:, at(f"{side}_{end}")] - positions[:, at(f"{side}_{start}")]
         for side in ("left", "right") for start, end in BONES], 1)  # fmt: skip
    return ways / np.linalg.norm(ways, axis=-1, keepdims=True)


@pytest.mark.parametrize("kind", ["mixamo", "unreal 5", "strange"])
def test_a_walk_on_another_rig_comes_back(tmp_path, kind):
    motion = recordings.walk(14)
    (recording,), found = mapped([formats.read(exported(tmp_path / "a.fbx", kind, motion))])
    back = retargeted(recording, found)
    shown = directions(places(recording, found), found.bones.get)
    made = directions(back.forward_kinematics()[0], skeleton.INDEX.get)
    off = np.degrees(np.arccos(np.clip((shown * made).sum(-1), -1, 1)))
    arms = [2, 3, 6, 7]
    assert len(back) == len(motion)
    assert off[:, arms].max() < 0.5 and off.max() < 5.0
    for side in ("left", "right"):
        bent = flexion(motion.forward_kinematics()[0], "knee", side)
        assert np.abs(flexion(back.forward_kinematics()[0], "knee", side) - bent).mean() < 5.0
    (clip,) = importer.imported([recording], "a")
    assert np.abs(clip.motion.root[:, 1] - motion.root[:, 1]).mean() < 0.03


def test_a_take_without_skin_borrows_its_rest_pose_from_another(tmp_path):
    """The walk begins in the middle of a step; somebody stands in the other file."""
    motion = recordings.walk(14)
    standing = Motion(np.tile([0.0, 0.95, 0.0], (14, 1)), np.tile([1.0, 0.0, 0.0, 0.0], (14, 22, 1)))
    files = [bare(tmp_path / "a_walk.fbx", motion), bare(tmp_path / "a_stand.fbx", standing)]
    ((_, read),) = importer.recordings_of(files, importer.SUBJECT, [])
    together, found = mapped(read)
    back = retargeted(together[0], found)
    off = rotation.multiply(rotation.conjugate(motion.rotations), back.rotations)
    assert np.degrees(np.linalg.norm(rotation.to_axis_angle(off), axis=-1)).max() < 0.5
    with pytest.raises(SampError, match="upright body"):
        mapped([formats.read(files[0])])
