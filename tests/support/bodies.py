"""Bodies that stand still."""

from __future__ import annotations

import numpy as np
import rooms
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.motion import Motion

FLOOR = rooms.box(np.array([-4.0, -0.1, -4.0]), np.array([4.0, 0.0, 4.0]))


def standing(seconds=2.0, fps=30.0, at=(0.0, 0.0, 0.0)):
    """Return a body that stands still, arms down, and sways a little."""
    frames = round(seconds * fps) + 1
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (frames, 22, 1))
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotations[:, skeleton.INDEX[f"{side}_shoulder"]] = rotation.from_axis_angle(
            np.array([0, 0, sign * 1.2])
        )
    root = np.tile(np.array(at) + [0.0, -human.load().floor + 0.002, 0.0], (frames, 1))
    root[:, 0] += 0.004 * np.sin(np.arange(frames) / fps * 2)
    return Motion(root, rotations, fps)
