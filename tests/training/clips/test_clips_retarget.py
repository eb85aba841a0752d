"""A known motion on other skeletons, brought back onto ours: whatever the rest pose, the unit, the axes, the names."""

from __future__ import annotations

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.errors import SampError
from samp_blender.training.clips import formats, mapping, straightness
from samp_blender.training.clips.mapping import mapped
from samp_blender.training.clips.quality import flexion
from samp_blender.training.clips.recording import Recording
from samp_blender.training.clips.retarget import reached, retargeted, shared_twist

LEFT_ARM = np.array([skeleton.INDEX[f"left_{part}"] for part in ("shoulder", "elbow", "wrist")])
PREFIXED = {joint: f"mixamorig:{bone}" for joint, bone in recordings.MIXAMO.items()}
BIPED = dict(zip(
    skeleton.BODY_JOINTS,
    ("Bip Pelvis", "Bip L Thigh", "Bip R Thigh", "Bip Spine", "Bip L Calf", "Bip R Calf", "Bip Spine1", "Bip L Foot",
     "Bip R Foot", "Bip Spine2", "Bip L Toe0", "Bip R Toe0", "Bip Neck", "Bip L Clavicle", "Bip R Clavicle",
     "Bip Head", "Bip L UpperArm", "Bip R UpperArm", "Bip L Forearm", "Bip R Forearm", "Bip L Hand", "Bip R Hand"),
    strict=True))  # fmt: skip


def still() -> np.ndarray:
    """No rotation, for each of the 22 joints."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (22, 1))


def hanging(degrees: float) -> np.ndarray:
    """Global rotations (22, 4) of a rest pose whose arms hang this much under the T-pose."""
    rest = still()
    for side, sign in (("left", -1), ("right", 1)):
        turn = rotation.from_axis_angle(np.array([0.0, 0.0, sign * np.radians(degrees)]))
        for part in ("shoulder", "elbow", "wrist"):
            rest[skeleton.INDEX[f"{side}_{part}"]] = turn
    return rest


def facing(degrees: float) -> np.ndarray:
    """Global rotations (22, 4) of a T-pose that faces aside."""
    return np.tile(rotation.about_y(np.radians(degrees)), (22, 1))


def scrambled() -> np.ndarray:
    """Global rotations (22, 4) of an impossible rest pose: each bone at random."""
    return rotation.from_axis_angle(np.random.default_rng(4).normal(size=(22, 3)))


@pytest.mark.parametrize(
    "names, unit, up, rest, roll",
    [
        (recordings.MIXAMO, 100.0, "Y", None, 0.2),
        (PREFIXED, 1.0, "Z", None, 0.2),
        (BIPED, 39.37, "Z", hanging(45.0), 7.0),
        (recordings.MIXAMO, 1000.0, "Y", hanging(70.0), 11.0),
        (recordings.MIXAMO, 1.0, "Y", facing(90.0), 0.2),
    ],
    ids=["cm", "Z up", "biped in an A-pose, inches", "arms down, mm", "facing aside"],
)
def test_a_motion_comes_back_from_other_skeletons(tmp_path, names, unit, up, rest, roll):
    """A hanging arm does not determine its roll at rest; its bones keep their places."""
    motion = recordings.walk(30)
    path = recordings.write_bvh(tmp_path / "a.bvh", motion, "ZXY", unit, up, names, rest)
    (recording,), found = mapped([formats.read(path)])
    back = retargeted(recording, found)
    yaw = -90.0 if rest is not None and np.allclose(rest[0], facing(90.0)[0]) else 0.0
    same(back, motion, yaw, angle=roll)


def same(back, motion, yaw=0.0, near=1e-3, angle=0.2):
    """Joints within a millimetre and rotations within an angle, degrees, the world turned by yaw degrees."""
    root, rotations = recordings.turned(motion.root, motion.rotations, np.radians(yaw))
    wanted, _ = skeleton.forward_kinematics(root, rotations, recordings.REST)
    found, _ = back.forward_kinematics()
    assert np.abs(found[:, :22] - wanted).max() < near
    off = rotation.to_axis_angle(rotation.multiply(rotation.conjugate(rotations), back.rotations))
    assert np.degrees(np.linalg.norm(off, axis=-1)).max() < angle


def test_where_the_rest_pose_means_nothing_a_standing_pose_takes_its_place(tmp_path):
    """The pose of a standing person is no T-pose of SMPL-X; bones still point where they did."""
    motion = recordings.walk(60)
    legs = [
        skeleton.INDEX[f"{side}_{part}"] for side in ("left", "right") for part in ("hip", "knee", "ankle")
    ]
    motion.rotations[45:] = motion.rotations[45]
    motion.rotations[45:, legs] = [1.0, 0.0, 0.0, 0.0]
    motion.root[45:] = motion.root[45] + [0.0, 0.06, 0.0]
    path = recordings.write_bvh(tmp_path / "a.bvh", motion, rest=scrambled())
    recording = formats.read(path)
    bones = mapping.joints_of(recording)
    assert not mapping.stands(recording.rest, bones)
    together, found = mapped([recording])
    back = retargeted(together[0], found).forward_kinematics()[0]
    yaw = np.degrees(np.arctan2(found.axes[0, 2], found.axes[2, 2]))
    wanted, _ = skeleton.forward_kinematics(
        *recordings.turned(motion.root, motion.rotations, -np.radians(yaw)), recordings.REST
    )
    for side in ("left", "right"):
        for start, end in (("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee")):
            a, b = skeleton.INDEX[f"{side}_{start}"], skeleton.INDEX[f"{side}_{end}"]
            u, v = back[:, b] - back[:, a], wanted[:, b] - wanted[:, a]
            cosine = np.sum(u * v, -1) / np.linalg.norm(u, axis=-1) / np.linalg.norm(v, axis=-1)
            assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 2.0


def test_acclaim_skeletons_come_back_too(tmp_path):
    motion = recordings.walk(60, fps=120.0)
    (recording,), found = mapped([formats.read(recordings.write_acclaim(tmp_path, motion))])
    assert recording.names[found.bones["left_hip"]] == "lfemur"
    same(retargeted(recording, found), motion.pose_slice(slice(None, None, 4)))


def test_without_legs_there_is_no_mapping():
    legs = ("hip", "knee", "ankle", "foot")
    kept = [j for j, joint in enumerate(skeleton.BODY_JOINTS) if not joint.endswith(legs)]
    parents = np.array([kept.index(p) if p >= 0 else -1 for p in skeleton.PARENTS[kept]])
    positions, globals_ = recordings.walk(3).forward_kinematics()
    names = tuple(f"bone{k}" for k in range(len(kept)))
    one = Recording("a", 30.0, names, parents, recordings.REST[kept], recordings.REST[kept], positions[:, kept],
                    globals_[:, kept], still()[kept])  # fmt: skip
    with pytest.raises(SampError, match="recognised as.*left_hip"):
        mapped([one])


def test_a_recording_at_another_rate_keeps_its_time():
    motion = recordings.walk(120, fps=120.0)
    positions, globals_ = motion.forward_kinematics()
    one = Recording("a", 120.0, skeleton.BODY_JOINTS, skeleton.PARENTS[:22], recordings.REST, recordings.REST,
                    positions, globals_, still())  # fmt: skip
    slow = one.at_rate(30.0)
    assert len(slow) == 30 and np.allclose(slow.positions, positions[::4])


def standing(flex: float, count: int = 90) -> np.ndarray:
    """Poses (T, 22, 3) of a person standing with bent knees, degrees; joint positions."""
    vectors = np.zeros((count, 22, 3))
    for side in ("left", "right"):
        vectors[:, skeleton.INDEX[f"{side}_hip"], 0] = -np.radians(flex) / 2
        vectors[:, skeleton.INDEX[f"{side}_knee"], 0] = np.radians(flex)
    return skeleton.forward_kinematics(
        np.tile([0, 0.93, 0], (count, 1)), rotation.from_axis_angle(vectors), recordings.REST
    )


@pytest.mark.parametrize(
    "flex, made", [(10.0, (10, 16)), (20.0, (10, 16)), (30.0, (10, 18)), (60.0, (55, 70))]
)
def test_legs_that_never_straighten_are_taken_for_too_long(flex, made):
    """Standing is made as straight as people stand; a crouch so deep that the hips are low is one, and stays."""
    positions, globals_ = standing(flex)
    one = Recording("a", 30.0, skeleton.BODY_JOINTS, skeleton.PARENTS[:22], recordings.REST, recordings.REST,
                    positions, globals_, still())  # fmt: skip
    together, found = mapped([one])
    leg, _ = straightness.corrections(together, found)
    knees = flexion(retargeted(together[0], found, leg).forward_kinematics()[0], "knee", "left")
    assert made[0] < np.median(knees) < made[1]


def test_a_target_out_of_reach_is_drawn_in_smoothly():
    motion = recordings.walk(40)
    joints, _ = motion.forward_kinematics()
    hip = joints[:, skeleton.INDEX["left_hip"]]
    length = sum(
        np.linalg.norm(recordings.OFFSETS[skeleton.INDEX[f"left_{part}"]]) for part in ("knee", "ankle")
    )
    far = np.linspace(0.9, 1.1, 40) * length
    made = reached(motion.root, motion.rotations, recordings.REST, "left_leg", hip - far[:, None] * [0, 1, 0])
    got, _ = skeleton.forward_kinematics(motion.root, made, recordings.REST)
    reach = np.linalg.norm(got[:, skeleton.INDEX["left_ankle"]] - hip, axis=-1) / length
    assert np.allclose(reach[:15] * length, far[:15], atol=1e-4)
    assert reach.max() < 0.9985 and (np.diff(reach) > -1e-6).all()


def test_forearms_take_half_of_the_twist_of_hands():
    axis = recordings.OFFSETS[LEFT_ARM[2]] / np.linalg.norm(recordings.OFFSETS[LEFT_ARM[2]])
    local = np.tile([1.0, 0.0, 0.0, 0.0], (5, 22, 1))
    local[:, LEFT_ARM[2]] = rotation.from_axis_angle(np.linspace(0.2, 1.2, 5)[:, None] * axis)
    made = shared_twist(local, recordings.REST)
    assert np.allclose(made[:, LEFT_ARM[1]], made[:, LEFT_ARM[2]])
    whole = rotation.multiply(made[:, LEFT_ARM[1]], made[:, LEFT_ARM[2]])
    assert np.allclose(whole, local[:, LEFT_ARM[2]])
    local[:, LEFT_ARM[1]] = local[:, LEFT_ARM[2]]  # a forearm that turns by itself keeps it
    assert np.allclose(shared_twist(local, recordings.REST)[:, LEFT_ARM], local[:, LEFT_ARM])
