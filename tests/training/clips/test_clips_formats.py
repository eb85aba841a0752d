"""Motion capture files of a known motion, read back: joints within 0.1 mm, rotations within 0.01 degrees."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
import recordings
import rigs
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.errors import SampError
from samp_blender.training.clips import formats
from samp_blender.training.clips.formats import source

Y_UP, Z_UP = np.eye(3), np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
NEAR, ANGLE = 1e-4, np.radians(0.01)


def angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Radians between quaternions."""
    return np.linalg.norm(rotation.to_axis_angle(rotation.multiply(rotation.conjugate(a), b)), axis=-1)


def checked(recording, motion, names, unit=1.0, axes=Y_UP, near=NEAR, angle=ANGLE):
    """The joints of a recording are the motion's."""
    positions, globals_ = motion.forward_kinematics()
    at = [recording.names.index(names[name]) for name in skeleton.BODY_JOINTS]
    assert len(recording) == len(motion)
    assert recording.fps == pytest.approx(motion.fps, rel=1e-4)
    assert np.abs(recording.positions[:, at] @ axes / unit - positions).max() < near
    assert angles(rotation.change_basis(recording.unfolded()[:, at], axes.T), globals_).max() < angle
    assert np.abs((recording.rest[at] - recording.rest[at[0]]) @ axes / unit - recordings.REST).max() < near


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "ZYX", "YXZ"])
@pytest.mark.parametrize("up, unit", [("Y", 100.0), ("Z", 1.0)])
def test_bvh(tmp_path, order, up, unit):
    motion = recordings.walk(8, turn=0.7)
    axes = Y_UP if up == "Y" else Z_UP
    found = formats.read(recordings.write_bvh(tmp_path / "a.bvh", motion, order.upper(), unit, up))
    checked(found, motion, recordings.MIXAMO, unit, axes)


@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_acclaim(tmp_path, tilt):
    motion = recordings.walk(8, fps=120.0, turn=-1.1)
    found = formats.read(recordings.write_acclaim(tmp_path, motion, tilt=tilt))
    checked(found, motion, recordings.ACCLAIM, 0.45 / 0.0254)


def test_npz(tmp_path):
    motion = recordings.walk(8)
    found = formats.read(recordings.write_source(tmp_path / "a.npz", motion))
    checked(found, motion, recordings.MIXAMO)
    assert set(found.labels) == {"walk"}


@pytest.fixture
def exported():
    """A walk on the human in an otherwise empty file; an FBX keeps rest poses of skinned armatures only."""
    rigs.reset()
    owner = character.create_character(bpy.context)
    motion = recordings.walk(8, turn=0.4)
    keyframes.write_motion(owner, motion)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, len(motion)
    return motion


def test_fbx(tmp_path, exported):
    path = tmp_path / "a.fbx"
    bpy.ops.export_scene.fbx(
        filepath=str(path), object_types={"ARMATURE", "MESH"}, bake_anim_simplify_factor=0.0,
        add_leaf_bones=False, bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False,
    )  # fmt: skip
    found = formats.read(path)
    checked(found, exported, {name: name for name in skeleton.JOINTS}, near=5e-4, angle=np.radians(0.05))


def test_bvh_as_blender_writes_it(tmp_path, exported):
    path = tmp_path / "a.bvh"
    bpy.ops.export_anim.bvh(
        filepath=str(path),
        frame_start=1,
        frame_end=len(exported),
        rotate_mode="NATIVE",
        root_transform_only=False,
    )
    found = formats.read(path)
    checked(
        found,
        exported,
        {name: name for name in skeleton.JOINTS},
        axes=Z_UP,
        near=5e-4,
        angle=np.radians(0.05),
    )


def test_the_figure_of_the_cmu_conversion_has_straight_limbs_and_its_own_feet(tmp_path):
    names = ["hip", "abdomen", "chest", "neck", "head"]
    parents, offsets = [-1, 0, 1, 2, 3], [[0, 0, 0], [0, 0.2, 0], [0, 0.12, 0], [0, 0.22, 0], [0, 0.07, 0]]
    for side, sign in (("r", -1), ("l", 1)):
        arm = [f"{side}{part}" for part in ("Collar", "Shldr", "ForeArm", "Hand")]
        leg = [f"{side}{part}" for part in ("Thigh", "Shin", "Foot")]
        first = len(names)
        names += arm + leg
        parents += [2, first, first + 1, first + 2, 0, first + 4, first + 5]
        offsets += [
            [0.03 * sign, 0.19, 0],
            [0.09 * sign, 0, 0],
            [0.28 * sign, 0, 0],
            [0.226 * sign, 0, 0.071],
        ]
        offsets += [[0.09 * sign, 0, 0], [0, -0.367, 0.035], [0, -0.453, -0.035]]
    quats = np.tile([0.0, 0.0, 0.0, 1.0], (5, len(names), 1))
    path = tmp_path / "01_01.npz"
    np.savez(
        path, root_pos=np.tile([0.0, 0.85, 0.0], (5, 1)), local_quat_xyzw=quats, offsets=offsets,
        parents=parents, names=names, fps=30,
    )  # fmt: skip
    found = source.read(path)
    at = lambda name: found.positions[0, names.index(name)]
    hip, foot = at("lThigh"), at("lFoot")
    assert foot[1] == pytest.approx(0.85 - 0.367 - 0.453)  # where the file has it
    assert hip[1] - foot[1] == pytest.approx(np.hypot(0.367, 0.035) + np.hypot(0.453, 0.035), abs=1e-6)
    rest = lambda name: found.rest[names.index(name)]
    assert np.allclose((rest("lHand") - rest("lShldr"))[1:], 0)


@pytest.mark.parametrize(
    "name, text, part",
    [
        ("a.bvh", "HIERARCHY\nnothing", "not a readable BVH"),
        ("a.bvh", "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 0\n}\nMOTION\nFrames: 0\nFrame Time: 0.1\n",
         "contains no motion"),
        ("a.amc", ":DEGREES\n1\nroot 0 0 0 0 0 0\n", "needs the .asf file"),
        ("a.txt", "", "unknown format"),
        ("a.fbx", "not an fbx", "Blender cannot read"),
    ],
)  # fmt: skip
def test_a_broken_file_is_told_in_one_sentence(tmp_path, name, text, part):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(SampError, match=part) as caught:
        formats.read(path)
    assert "\n" not in str(caught.value)
