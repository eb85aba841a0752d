"""Refinement without Blender: energies against closed forms, and takes with errors that are removed."""

from dataclasses import replace

import numpy as np
import pytest
import rooms
import torch
from bodies import FLOOR, standing
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.evaluation import collision, feet, metrics
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.refine import energies, pose, refinement
from samp_blender.samp_addon.refine.feet.plan import plan_feet
from samp_blender.samp_addon.refine.field import Field
from samp_blender.samp_addon.refine.refinement import Settings, Surroundings, refine


def surroundings(*pieces, give=0.0, floor=0.0):
    triangles = np.concatenate([FLOOR, *pieces])
    return Surroundings(
        triangles, np.r_[np.zeros(len(FLOOR)), np.full(len(triangles) - len(FLOOR), give)], floor
    )


def depth(motion, scene):
    return collision.body_depth(motion, scene.obstacles, scene.floor)[0].max(1)


def test_skin_matches_the_body_and_spline_weights_add_up():
    motion, body = standing(0.5), human.load()
    made = pose.Pose(motion, body)
    still = made.locally(torch.zeros(len(motion), 22, 3))
    placed, turned = made.joints(torch.zeros(len(motion), 3), still)
    np.testing.assert_allclose(placed.numpy(), motion.forward_kinematics()[0], atol=1e-5)
    rows, frames = torch.tensor([0, 7]), np.ones(2048, int)
    skin, vertices = pose.Skin(body, body.collision), np.arange(2048)
    before, after = motion.pose_slice(np.array([0, 0])), made.transforms(placed, turned, rows)
    for axis in np.eye(3):
        along = skin.along(before, frames, vertices, np.tile(axis, (2048, 1)))
        found = along.start + along.at(after).numpy()
        np.testing.assert_allclose(found, human.skin(body, motion, body.collision)[7] @ axis, atol=1e-5)
    np.testing.assert_allclose(pose.spline_basis(50, 24.0).sum(1), 1.0)


def test_changes_agree_between_torch_and_motion():
    motion = standing(0.3)
    rng = np.random.default_rng(0)
    shift, turn = 0.1 * rng.standard_normal((len(motion), 3)), 0.3 * rng.standard_normal((len(motion), 22, 3))
    tensor = lambda a: torch.tensor(a, dtype=torch.float32)
    made = pose.Pose(motion, human.load())
    placed, _ = made.joints(tensor(shift), made.locally(tensor(turn)))
    moved = pose.changed(motion, shift, turn).forward_kinematics()[0]
    np.testing.assert_allclose(placed.numpy(), moved, atol=2e-5)


ENERGIES = {
    "collision": (lambda: energies.collision(torch.tensor([-0.02, 0.01, 0.5]), 0.0, 2), 0.01),
    "collision keeps off": (lambda: energies.collision(torch.tensor([0.001]), 0.003, 1), 0.002),
    "contact half way": (lambda: energies.contact(torch.tensor([energies.CONTACT_SCALE]), 0.0, 1), 0.5),
    "contact touching": (lambda: energies.contact(torch.tensor([0.001, -0.01]), 0.003, 1), 0.0),
    "foot": (lambda: energies.foot_location(torch.zeros(2, 1, 3), torch.tensor([[[3.0, 4.0, 0.0]]] * 2),
                                            torch.tensor([[1.0], [0.0]])), 2.5),
    "smooth": (lambda: energies.smoothness(torch.tensor([[[0.0, 0, 0]], [[0.3, 0.4, 0]]])), 0.25),
    "smooth at rest": (lambda: energies.smoothness(torch.ones(5, 3, 3)), 0.0),
    "close": (lambda: energies.closeness(torch.full((2, 3), 0.1), torch.zeros(2, 22, 3), torch.ones(22)),
              0.03 * energies.SHIFT),
}  # fmt: skip


@pytest.mark.parametrize("name", ENERGIES)
def test_energies_match_their_equations(name):
    value, wanted = ENERGIES[name]
    assert float(value()) == pytest.approx(wanted, abs=2e-3)


def test_joint_limits_penalise_excess_only():
    limits = torch.full((22,), 1.0)
    turn = torch.zeros(1, 22, 3)
    turn[0, 5, 0] = 0.95
    assert float(energies.joint_limits(pose.rotation_matrices(turn), limits)) == 0.0
    turn[0, 5, 0] = 1.3
    assert float(energies.joint_limits(pose.rotation_matrices(turn), limits)) > 0.01


def test_on_goal_measures_place_and_facing():
    joints = torch.tensor(standing(0.1).forward_kinematics()[0], dtype=torch.float32)
    goal, ahead, aside = joints[0, 0], torch.tensor([0.0, 0.0, 1.0]), torch.tensor([1.0, 0.0, 0.0])
    resting = torch.ones(len(joints))
    assert float(energies.on_goal(joints, goal, ahead, resting)) < 1e-4
    assert float(energies.on_goal(joints, goal, aside, resting)) == pytest.approx(
        2 * energies.TURN**2, rel=0.05
    )


@pytest.fixture(scope="module")
def crate():
    """A crate that intersects an arm and a hip of the standing body."""
    return rooms.box(np.array([0.13, 0.0, -0.3]), np.array([0.8, 1.1, 0.5]))


def test_a_body_in_a_crate_is_moved_out(crate):
    scene, motion = surroundings(crate), standing()
    assert depth(motion, scene).max() > 0.05
    made = refine(motion, scene)
    assert depth(made.motion, scene).max() < 0.01
    assert made.unsolved < 0.01 and not made.notes
    assert made.after["penetration_max_cm"] < made.before["penetration_max_cm"]
    assert feet.measures(made.motion)["stance_slide_cm_s"] < 1.0
    assert len(made.motion) == len(motion) and made.motion.fps == motion.fps


def test_sliding_feet_are_locked_to_the_floor():
    motion = standing(3.0)
    drift = np.linspace(0, 0.08, len(motion))
    motion = replace(motion, root=motion.root + np.stack([drift, 0 * drift - 0.01, 0 * drift], -1))
    made = refine(motion, surroundings())
    before, after = feet.measures(motion), feet.measures(made.motion)
    assert before["stance_slide_cm_s"] > 2 and after["stance_slide_cm_s"] < 0.5
    assert after["foot_depth_cm"] < 0.1


@pytest.mark.parametrize("pitch", [0.0, 0.2])
def test_feet_stand_on_what_is_under_them(pitch):
    """A step 18 cm high, level or tilted."""
    block = rooms.box(np.array([-1.0, -0.5, -1.0]), np.array([1.0, 0.0, 1.0]))
    turn = rotation.from_axis_angle(np.array([pitch, 0, 0]))
    block = rotation.rotate(np.broadcast_to(turn, (*block.shape[:2], 4)), block) + [0, 0.18, 0]
    motion = standing(1.5, at=(0.0, 0.18, 0.0))
    scene = surroundings(block)
    made = refine(motion, scene).motion
    field = Field(scene.triangles, scene.give, 0.0, np.array([[0.0, 2.0, 0.0]]))
    for patch in feet.sole_patches():
        skin = human.skin(human.load(), made, patch)[20:-5].reshape(-1, 3).astype(float)
        distance, _ = field.at(skin)
        assert distance.min() > -0.004 and np.median(distance) < 0.015


def test_a_cushion_yields(crate):
    """A body 3 cm inside a cushion that yields 4 cm stays there, and is moved out of a hard one."""
    motion = standing()
    arms = [skeleton.INDEX[f"{side}_shoulder"] for side in ("left", "right")]
    motion.rotations[:, arms] = rotation.from_axis_angle(
        np.array([[0, 0, 0.6], [0, 0, -0.6]])
    )  # up, out of the way
    shifted = replace(motion, root=motion.root - [0.02, 0.0, 0.0])
    hard, soft = surroundings(crate), surroundings(crate, give=0.04)
    assert 0.02 < depth(shifted, hard).max() < 0.04
    deep = [depth(refine(shifted, scene, measured=False).motion, hard).max() for scene in (hard, soft)]
    assert deep[0] < 0.01
    assert 0.015 < deep[1] < 0.045


def test_strength_is_a_share_of_the_change(crate):
    scene, motion = surroundings(crate), standing()
    whole, half, none = (
        refine(motion, scene, settings=Settings(strength=s), measured=False).motion for s in (1.0, 0.5, 0.0)
    )
    np.testing.assert_allclose(half.root - motion.root, 0.5 * (whole.root - motion.root), atol=1e-9)
    np.testing.assert_allclose(none.root, motion.root, atol=1e-12)


def test_the_pelvis_stays_on_its_goal(crate):
    motion = standing()
    goal = Goal(motion.root[-1] + [-0.05, 0.0, 0.0], np.array([0.0, 0.0, 1.0]), "walk")
    made = refine(motion, surroundings(crate), goal)
    assert made.after["position_error_cm"] < made.before["position_error_cm"] + 0.5
    assert made.after["rotation_error_deg"] < made.before["rotation_error_deg"] + 1.0


def test_windows_cover_a_long_take_and_overlap():
    assert refinement.windows(240, 30.0) == [(0, 240)]
    seams = []
    for stage in (0, 1):
        spans = refinement.windows(1800, 30.0, stage)
        assert spans[0][0] == 0 and spans[-1][1] == 1800
        for (_, end), (start, _) in zip(spans[:-1], spans[1:], strict=True):
            assert end - start == 30
            seams.append(start)
    assert np.diff(np.sort(seams)).min() > 60


def test_a_long_take_has_no_seam(crate):
    motion = standing(20.0, fps=15.0)
    made = refine(motion, surroundings(crate), measured=False).motion
    steps = np.linalg.norm(np.diff(made.forward_kinematics()[0], axis=0), axis=-1).max(1)
    assert steps.max() < 0.03
    assert depth(made, surroundings(crate)).max() < 0.03


def test_refinement_is_deterministic(crate):
    first, second = (refine(standing(1.0), surroundings(crate), measured=False).motion for _ in range(2))
    np.testing.assert_array_equal(first.rotations, second.rotations)


def test_remaining_penetration_is_reported():
    wall = rooms.box(np.array([-3.0, 0.0, -3.0]), np.array([3.0, 2.5, 3.0]))
    motion = standing(1.0)
    # In the first frames the body is outside, so that the block counts as solid.
    away = replace(
        motion, root=np.where(np.arange(len(motion))[:, None] < 20, motion.root + [0, 0, 3.6], motion.root)
    )
    made = refine(away, surroundings(wall), measured=False)
    assert made.unsolved > 0.02 and "deep" in made.notes[0]


def test_values_that_are_not_finite_are_reported_by_bone_and_frame():
    motion = standing(1.0)
    motion.rotations[7, skeleton.INDEX["left_knee"], 2] = np.nan
    with pytest.raises(SampError, match="Frame 7.*left_knee"):
        refine(motion, surroundings())


def test_an_empty_surrounding_is_an_error():
    with pytest.raises(SampError, match="No visible object"):
        refine(standing(1.0, at=(50.0, 0.0, 0.0)), surroundings())


def test_what_progress_raises_stops_the_work(crate):
    class Stopped(Exception):
        pass

    def report(stage, share):
        if share > 0.2:
            raise Stopped

    with pytest.raises(Stopped):
        refine(standing(), surroundings(crate), progress=report)


def test_jerk_does_not_rise(crate):
    motion = standing(3.0)
    jittering = replace(
        motion, root=motion.root + 0.002 * np.random.default_rng(0).standard_normal(motion.root.shape)
    )
    made = refine(jittering, surroundings(crate), measured=False).motion
    assert metrics.jerk(made) < metrics.jerk(jittering)


def test_a_floor_that_is_a_plane_is_solid_below():
    plane = np.array([[[-4, 0, -4], [-4, 0, 4], [4, 0, -4]], [[4, 0, 4], [4, 0, -4], [-4, 0, 4]]], float)
    motion = standing(1.5)
    sunk = replace(motion, root=motion.root - [0.0, 0.03, 0.0])
    made = refine(sunk, Surroundings(plane, np.zeros(2)))
    assert feet.measures(made.motion)["foot_depth_cm"] < 0.1
    assert made.before["penetration_max_cm"] > 2.5 and made.after["penetration_max_cm"] < 0.1


def test_feet_that_left_the_ground_stay_finite():
    """A plan that is updated after the ground went out of reach."""
    motion = standing(1.0)
    field = Field(surroundings().triangles, surroundings().give, 0.0, np.array([[0.0, 2.0, 0.0]]))
    up = replace(motion, root=motion.root + [0.0, 0.5, 0.0])
    again = plan_feet(up, field, plan_feet(motion, field))
    for plan in again:
        assert plan.standing.all() and np.isfinite(plan.ankle).all() and np.isfinite(plan.orientation).all()
        assert np.abs(plan.ankle[:, 1] - 0.5).max() < 0.15
