"""APD frame by frame: 0 for identical takes, whatever they do in time; the paper's pooled one is not."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.evaluation import diversity
from samp_blender.samp_addon.motion import Motion


def sit_down(seconds=(2.0, 1.0, 2.0), arm=0.3, yaw=0.0, at=(0.0, 0.0)):
    """Return a walk, a way down and a rest of these lengths, one arm swinging by an angle (radians) all the time."""
    lengths = [round(30 * part) for part in seconds]
    total, begun = sum(lengths), lengths[0]
    time = np.concatenate([k + np.arange(n) / n for k, n in enumerate(lengths)])
    rotations = np.zeros((total, 22, 4))
    rotations[..., 0] = 1
    rotations[:, 0] = rotation.about_y(np.full(total, yaw))
    swing = arm * np.sin(2 * np.pi * time)
    rotations[:, skeleton.INDEX["left_shoulder"]] = rotation.from_axis_angle(
        swing[:, None] * np.array([0.0, 0.0, 1.0])
    )
    height = np.concatenate(
        [np.full(begun, 0.95), np.linspace(0.95, 0.6, lengths[1]), np.full(lengths[2], 0.6)]
    )
    ahead = np.minimum(time, 1.0) * 2.0
    root = np.stack([at[0] + np.sin(yaw) * ahead, height, at[1] + np.cos(yaw) * ahead], -1)
    return Motion(root, rotations, interaction_start=begun)


def test_ten_identical_takes_have_no_diversity():
    takes = [sit_down()] * 10
    assert diversity.diversity_in_time(takes) == pytest.approx(0, abs=1e-12)
    assert diversity.diversity(takes) > 0.1  # the paper's counts the change over time


def test_place_and_facing_are_removed():
    takes = [sit_down(), sit_down(yaw=1.2, at=(3.0, -2.0))]
    assert diversity.diversity_in_time(takes) == pytest.approx(0, abs=1e-3)


def test_different_takes_differ():
    little = diversity.diversity_in_time([sit_down(arm=0.3), sit_down(arm=0.35)])
    much = diversity.diversity_in_time([sit_down(arm=0.3), sit_down(arm=-1.0)])
    assert 0 < little < much / 20


def test_phases_are_aligned_and_not_frames():
    slow = sit_down(seconds=(4.0, 1.0, 2.0))
    assert [part.stop - part.start for part in diversity.phases(slow)][0] == 120
    assert len(diversity.aligned_features(slow)) == 3 * diversity.STEPS
    features = [
        diversity.aligned_features(take).reshape(-1, 22, 4, 3)[:, :, :3] for take in (slow, sit_down())
    ]
    assert np.abs(features[0] - features[1]).max() < 0.06  # poses; velocities do differ


def test_a_take_that_does_not_rest_has_one_phase():
    walk = replace(sit_down(), interaction_start=None)
    assert diversity.phases(walk) == [slice(0, len(walk))]
    assert diversity.diversity_in_time([walk]) == 0
