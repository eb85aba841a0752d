"""Sheets, slats and wires that pass through a body are pushed to its nearest skin."""

import numpy as np
import pytest
import torch
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.evaluation import collision
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.refine import energies
from samp_blender.samp_addon.refine.refinement import Settings, Surroundings, refine
from samp_blender.samp_addon.refine.thin_things import ThinThings

BODY = human.load()
SEAT = 0.45


def sitting(sunk, frames=24):
    """Return a seated body, its thighs an amount (metres) through a sheet at SEAT."""
    rotations = np.zeros((frames, 22, 4))
    rotations[..., 0] = 1
    for side in ("left", "right"):
        for joint, turn in (("hip", -85.0), ("knee", 85.0)):
            axis = np.array([np.radians(turn), 0.0, 0.0])
            rotations[:, skeleton.INDEX[f"{side}_{joint}"]] = rotation.from_axis_angle(axis)
    motion = Motion(np.zeros((frames, 3)), rotations, 15.0)
    main = BODY.weight_joints[np.arange(len(BODY.vertices)), BODY.weights.argmax(1)]
    thighs = np.flatnonzero(np.isin(main, [skeleton.INDEX["left_hip"], skeleton.INDEX["right_hip"]]))
    lowest = np.percentile(human.skin(BODY, motion.pose_slice(slice(0, 1)), thighs)[0, :, 1], 5)
    return Motion(np.tile([0.0, SEAT - sunk - lowest, 0.0], (frames, 1)), rotations, 15.0)


def around(sheet=True, give=0.0):
    floor = np.array([[[-4, 0, -4], [-4, 0, 4], [4, 0, -4]], [[4, 0, 4], [4, 0, -4], [-4, 0, 4]]], float)
    x, z = 0.3, (0.05, 0.26)
    a, b, c, d = [(-x, SEAT, z[0]), (-x, SEAT, z[1]), (x, SEAT, z[1]), (x, SEAT, z[0])]
    seat = np.array([[a, b, c], [a, c, d]], float)
    triangles = np.concatenate([floor, seat]) if sheet else floor
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
    assert set(found.row.tolist()) == {0, 1}
    assert float(found.depth.max()) == pytest.approx(depth(motion, around()) + 0.004, abs=0.004)
    assert float(found.out.norm(dim=-1).max()) == pytest.approx(1, abs=1e-4)


def test_what_yields_is_not_pushed_out():
    motion = sitting(0.03, 2)
    hard, soft = (thin_around(motion, around(give=g)).pierced(motion).depth for g in (0.0, 0.05))
    np.testing.assert_allclose(soft.numpy(), hard.numpy() - 0.05, atol=1e-5)
    assert float(energies.pierced(soft, 2)) == 0 < float(energies.pierced(hard, 2))


def test_the_energy_is_the_mean_over_frames_of_the_depths():
    assert float(energies.pierced(torch.tensor([0.02, -0.5, 0.04]), 2)) == pytest.approx(0.03)


def test_a_floor_is_no_thin_thing():
    assert thin_around(sitting(0.0, 2), around(sheet=False)) is None
