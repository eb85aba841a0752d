"""Clips for tests."""

from __future__ import annotations

import numpy as np
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.training.mocap.clip_files import Clip

FPS = 30


def clip(count, root=(0.0, 0.93, 0.0), velocity=(0.0, 0.0, 0.0), yaw=0.0, pose=(), label="walk"):
    """A pose (joint, degrees about X) that glides at a velocity, m/s, facing yaw."""
    quats = np.zeros((count, 22, 4))
    quats[..., 0] = 1
    for joint, degrees in pose:
        quats[:, skeleton.INDEX[joint]] = rotation.from_axis_angle(np.radians([degrees, 0.0, 0.0]))
    quats[:, 0] = rotation.multiply(rotation.about_y(yaw), quats[:, 0])
    places = np.array(root) + np.arange(count)[:, None] / FPS * np.array(velocity)
    return Clip(
        "01_01", places, quats, np.array([label] * count), np.zeros((count, 2)), np.zeros(count, bool)
    )
