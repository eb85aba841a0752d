"""What the training set is made of: natural locomotion, and lying down composed from parts."""

from dataclasses import replace

import numpy as np
import pytest
from clips import clip
from samp_blender.samp_addon import skeleton
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.scene.geometry import sample_surface
from samp_blender.samp_addon.scene.seats.postures import BED_TO_PELVIS
from samp_blender.training.composition import lies, recline
from samp_blender.training.composition.sits import Furnishing, collides
from samp_blender.training.mocap import natural, posture
from shapes import box

MATTRESS = 0.5
BED = box((-0.7, 0.0, -1.0), (0.7, MATTRESS, 1.0))
LYING = Goal(np.array([0.0, MATTRESS + BED_TO_PELVIS, 0.0]), np.array([0.0, 0.0, 1.0]), "lie")


SITTING = (("left_hip", -85), ("right_hip", -85), ("left_knee", 85), ("right_knee", 85))
LEGS_OUT = (("left_hip", -105), ("right_hip", -105), ("left_knee", 8), ("right_knee", 8))


@pytest.mark.parametrize("yaw, spoilt", [(0, False), (30, False), (90, True), (180, True)])
def test_steps_sideways_and_backwards_are_not_learnt(yaw, spoilt):
    marked = natural.astray_marked(clip(60, velocity=(0, 0, 1.0), yaw=np.radians(yaw)))
    assert marked.bad.all() == spoilt and marked.bad.any() == spoilt


def test_what_is_neither_walking_nor_standing_is_not_learnt():
    assert natural.astray_marked(clip(30, label="other")).bad.all()
    assert natural.styled(replace(clip(3), name="137_05_mirror")) and not natural.styled(clip(3))
    assert natural.on_foot(clip(3)) and not natural.on_foot(clip(3, label="lie"))
    assert natural.pace(clip(60, velocity=(0, 0, 1.1))) == pytest.approx(1.1, abs=0.01)


def furnishing(mesh):
    return Furnishing(0, sample_surface(mesh, 6000, seed=0)[0], [LYING])


@pytest.mark.parametrize("wall, sides", [(None, 2), ((0.75, 0.0, -1.0, 0.85, 2.0, 1.0), 1)])
def test_beds_are_got_into_over_their_free_edges(wall, sides):
    mesh = BED if wall is None else np.concatenate([BED, box(wall[:3], wall[3:])])
    found = lies.edges(furnishing(mesh))
    assert len(found) == sides
    for edge in found:
        assert edge.distance == pytest.approx(0.7, abs=0.03) and edge.mattress == pytest.approx(MATTRESS)
        assert abs(edge.out @ LYING.direction) < 1e-9


@pytest.mark.parametrize("side", [1, -1])
def test_the_swing_leads_from_the_edge_onto_the_mattress(side):
    out = np.array([side, 0.0, 0.0])
    before = clip(5, (side * 0.55, 0.66, 0.0), yaw=side * np.pi / 2, pose=SITTING, label="sit")
    after = clip(5, (0.0, 0.6, 0.0), pose=LEGS_OUT, label="lie_down")
    between = recline.swing(before, after, 36, MATTRESS, (LYING.position, out, 0.7))
    root = np.concatenate([before.root[-1:], between.root, after.root[:1]])
    quats = np.concatenate([before.rotations[-1:], between.rotations, after.rotations[:1]])
    joints, _ = skeleton.forward_kinematics(root, quats, skeleton.default_rest_joints())
    steps = np.linalg.norm(np.diff(joints, axis=0), axis=-1)
    assert steps.max() < 0.15, "no joint may jump"
    assert steps.max(1)[[0, -1]].max() < 0.03, "it sets off and ends gently"
    over = joints[1:-1, [skeleton.INDEX["left_ankle"], skeleton.INDEX["right_ankle"]]]
    assert (over[..., 1][(over @ out < 0.66)] > MATTRESS + recline.ANKLE_OVER - 0.02).all()
    assert (between.feet == 0).all() and (between.labels == "lie_down").all()


def test_a_recline_is_laid_onto_its_goal():
    floor = clip(40, (3.0, 0.15, 1.0), yaw=1.0, pose=LEGS_OUT, label="lie")
    laid = recline.laid(recline.Recline(floor, 10), LYING.position, 0.0)
    assert np.allclose(laid.root[20], LYING.position)
    joints, _ = skeleton.forward_kinematics(laid.root, laid.rotations, skeleton.default_rest_joints())
    across = joints[20, skeleton.INDEX["left_hip"]] - joints[20, skeleton.INDEX["right_hip"]]
    assert across[0] > 0.05 and abs(across[2]) < 0.01


@pytest.mark.parametrize("x, why", [(0.3, "stands in it"), (1.2, None)])
def test_nobody_stands_in_a_bed(x, why):
    standing = clip(30, (x, 0.93, 0.0))
    assert collides(standing, furnishing(BED), (0.0, 0.0, 0.0), np.zeros(30, bool)) == why


def leaning(subject, tilt, count=40):
    """Standing frames of a subject whose pelvis and all above it lean forward by some degrees."""
    standing = clip(count, pose=(("pelvis", tilt), ("left_hip", -tilt), ("right_hip", -tilt)), label="idle")
    return replace(standing, name=f"{subject}_01")


def test_everybody_gets_the_same_posture():
    crooked, straight = leaning("39", 17), leaning("16", 1)
    lying = replace(leaning("39", 17, 3), labels=np.array(["lie"] * 3))
    mended = posture.neutralised([crooked, straight, lying])
    for one in mended[:2]:
        assert np.allclose(np.median(posture.tilts(one), axis=0), list(posture.NEUTRAL.values()), atol=0.1)
    before, after = (skeleton.forward_kinematics(c.root, c.rotations, skeleton.default_rest_joints())[0]
                     for c in (crooked, mended[0]))  # fmt: skip
    legs = [
        skeleton.INDEX[f"{side}_{joint}"] for side in ("left", "right") for joint in ("hip", "knee", "foot")
    ]
    assert np.allclose(before[:, legs], after[:, legs], atol=1e-6), "feet and hips stay"
    assert not np.allclose(lying.rotations, mended[2].rotations), "the same correction in every pose"
