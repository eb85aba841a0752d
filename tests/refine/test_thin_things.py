"""Sheets, slats and wires that pass through a body are pushed to its nearest skin."""

import numpy as np
import pytest
import torch
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.evaluation import collision
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.refine import energies
from samp_blender.samp_addon.refine.high_seats import knee_rises, knees_raised
from samp_blender.samp_addon.refine.refinement import Settings, Surroundings, refine
from samp_blender.samp_addon.refine.thin_things import ThinThings

BODY = human.load()
SEAT = 0.45


def sitting(sunk, frames=24, hips=85.0, knees=85.0):
    """Return a seated body, its thighs an amount (metres) through a sheet at SEAT; hips, knees: degrees."""
    rotations = np.zeros((frames, 22, 4))
    rotations[..., 0] = 1
    for side in ("left", "right"):
        for joint, turn in (("hip", -hips), ("knee", knees)):
            axis = np.array([np.radians(turn), 0.0, 0.0])
            rotations[:, skeleton.INDEX[f"{side}_{joint}"]] = rotation.from_axis_angle(axis)
    motion = Motion(np.zeros((frames, 3)), rotations, 15.0)
    main = BODY.weight_joints[np.arange(len(BODY.vertices)), BODY.weights.argmax(1)]
    thighs = np.flatnonzero(np.isin(main, [skeleton.INDEX["left_hip"], skeleton.INDEX["right_hip"]]))
    skin = human.skin(BODY, motion.pose_slice(slice(0, 1)), thighs)[0]
    lowest = np.percentile(skin[:, 1], 5) if hips > 80 else -0.17
    return Motion(np.tile([0.0, SEAT - sunk - lowest, 0.0], (frames, 1)), rotations, 15.0)


def around(sheet=True, give=0.0, seat=(0.05, 0.26)):
    """Return a floor and a sheet, seat: metres in front of the pelvis between which it is."""
    floor = np.array([[[-4, 0, -4], [-4, 0, 4], [4, 0, -4]], [[4, 0, 4], [4, 0, -4], [-4, 0, 4]]], float)
    x, z = 0.3, seat
    a, b, c, d = [(-x, SEAT, z[0]), (-x, SEAT, z[1]), (x, SEAT, z[1]), (x, SEAT, z[0])]
    top = np.array([[a, b, c], [a, c, d]], float)
    triangles = np.concatenate([floor, top]) if sheet else floor
    return Surroundings(triangles, np.where(triangles[:, :, 1].min(1) > 0.1, give, 0.0), 0.0)


def thin_around(motion, scene):
    return ThinThings.around(motion, scene.triangles, scene.give, BODY, scene.floor)


def depth(motion, scene):
    return collision.surface_depth(motion, scene.obstacles, scene.floor).max()


def test_a_sheet_through_the_thighs_ends_under_them():
    motion, scene = sitting(0.04), around()
    assert depth(motion, scene) > 0.03
    made = refine(motion, scene, settings=Settings(thin=1.0), measured=False).motion
    assert depth(made, scene) < 0.012
    assert np.abs(made.root - motion.root).max() < 0.1


@pytest.mark.parametrize("sunk", [-0.12, 0.03])
def test_pierced_samples_and_their_depth(sunk):
    motion = sitting(sunk, 2)
    thin = thin_around(motion, around())
    found = thin.pierced(motion)
    if sunk < 0:
        assert found is None
        return
    assert set(found.weight.tolist()) == {2.0}  # the second frame is like the first
    assert float(found.depth.max()) == pytest.approx(depth(motion, around()) + 0.004, abs=0.004)
    assert float(np.linalg.norm(found.out, axis=-1).max()) == pytest.approx(1, abs=1e-4)


def test_what_yields_is_not_pushed_out():
    motion = sitting(0.03, 2)
    hard, soft = (thin_around(motion, around(give=g)).pierced(motion).depth for g in (0.0, 0.05))
    np.testing.assert_allclose(soft.numpy(), hard.numpy() - 0.05, atol=1e-5)
    energy = lambda depth: float(energies.pierced(depth, torch.ones(len(depth)), 2))
    assert energy(soft) == 0 < energy(hard)


def test_the_energy_is_the_mean_over_frames_of_the_depths():
    depth, weight = torch.tensor([0.02, -0.5, 0.04]), torch.tensor([1.0, 1.0, 3.0])
    assert float(energies.pierced(depth, weight, 4)) == pytest.approx(0.035)


def test_seats_deep_in_the_thighs_are_pushed_out_downwards():
    motion = sitting(0.09, 1)  # the upper skin is nearer
    found = thin_around(motion, around(seat=(-0.2, 0.26))).pierced(motion)
    seat = found.seat
    assert seat.mean() > 0.8
    deepest = seat & (found.depth.numpy() > 0.05)
    assert deepest.sum() > 20
    assert (found.out[deepest, 1] < -0.9).all()


def test_a_back_rest_deep_in_the_trunk_is_pushed_out_backwards():
    motion, scene = sitting(0.0, 1), around(seat=(-0.2, 0.26))
    x, y, z = 0.3, (SEAT + 0.15, SEAT + 0.4), motion.root[0, 2] + 0.02
    a, b, c, d = [(-x, y[0], z), (x, y[0], z), (x, y[1], z), (-x, y[1], z)]
    triangles = np.concatenate([scene.triangles, np.array([[a, b, c], [a, c, d]])])
    goal = Goal(motion.root[0] + [0.0, 0.0, 0.1], np.array([0.0, 0.0, 1.0]), "sit")
    found = ThinThings.around(motion, triangles, np.zeros(len(triangles)), BODY, 0.0, goal).pierced(motion)
    back = (found.point[:, 2] == z) & (found.depth.numpy() > 0.06)
    assert back.sum() > 20
    assert (found.out[back, 2] < -0.9).all()


def test_a_table_over_the_thighs_is_no_seat():
    motion = sitting(0.0, 1)
    scene = around(seat=(0.10, 0.5))
    lifted = Surroundings(scene.triangles + [0.0, 0.11, 0.0], scene.give, 0.0)
    found = thin_around(motion, lifted).pierced(motion)
    assert len(found.depth) > 20
    assert not found.seat.any()


@pytest.mark.parametrize(("hips", "knees", "rises"), [(85.0, 85.0, False), (55.0, 10.0, True)])
def test_knees_rise_where_the_front_of_a_high_seat_is_in_the_thighs(hips, knees, rises):
    """Stretched legs slope down through the seat; bent ones lie on it."""
    motion = sitting(0.0, 30, hips, knees)
    scene = around(seat=(-0.2, 0.24))
    rise = knee_rises(motion, thin_around(motion, scene))
    assert (rise.max() > 0.05) == rises
    raised = knees_raised(motion, rise)
    if not rises:
        assert rise.max() == 0
        np.testing.assert_array_equal(raised.rotations, motion.rotations)
        return
    before, after = (thin_around(one, scene).deepest(one) for one in (motion, raised))
    assert before > 0.05
    assert after < 0.04
    np.testing.assert_allclose(raised.root, motion.root)


def test_a_floor_is_no_thin_thing():
    assert thin_around(sitting(0.0, 2), around(sheet=False)) is None
