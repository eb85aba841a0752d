"""A tiny data set of Scene GAN without a corpus: people who glide over a floor in front of a wall."""

from __future__ import annotations

import numpy as np
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.training.scene_gan.data.units import ROOT_UNIT

WIDTH, HEIGHT = 64, 36
FOCAL = 0.7
WINDOWS = 8
WAY = 1.2  # metres in a window


def arrays(sway: float = 0.5) -> dict[str, np.ndarray]:
    """Return the arrays of one room with two cameras and WINDOWS windows, named as in training/scene_gan/data/make.py.

    Each window glides in a direction of its own, its arms lifted by ``sway`` radians over time.
    """
    frames = np.arange(66)
    angle = 2 * np.pi * np.arange(WINDOWS) / WINDOWS
    way = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], -1)
    root = way[:, None] * (frames / 64 * WAY)[:, None] + [0.0, 0.93, 0.0]
    rotations = np.zeros((WINDOWS, 66, 22, 4))
    rotations[..., 0] = 1
    for name, sign in (("left_shoulder", -1), ("right_shoulder", 1)):
        turn = sign * sway * frames / 65
        turned = rotation.from_axis_angle(np.stack([0 * turn, 0 * turn, turn], -1))
        rotations[:, :, skeleton.INDEX[name]] = turned
    # Camera coordinates are x right, y down, z forward: cameras look along +Z and +X from 3 m away.
    ahead = np.array([[-1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]])
    aside = np.array([[0, 0, 1.0], [0, -1.0, 0], [1.0, 0, 0]])
    extrinsics = np.tile(np.eye(4), (2, 1, 1))
    for number, (turn, eye) in enumerate(((ahead, [0, 1.2, -3.0]), (aside, [-3.0, 1.2, 0]))):
        extrinsics[number, :3, :3], extrinsics[number, :3, 3] = turn, -turn @ eye
    pairs = [(camera, window) for window in range(WINDOWS) for camera in range(2)]
    heights = np.full((1, 80, 80), 255, np.uint8)
    heights[0, 10:70, 10:70] = 0
    heights[0, 50:60, 30:40] = 22
    depth = np.full((2, HEIGHT, WIDTH), 5000, np.uint16)
    depth[:, HEIGHT // 2 :] = np.linspace(5000, 1500, HEIGHT - HEIGHT // 2)[:, None]
    shade = np.linspace(60, 200, WIDTH).astype(np.uint8)
    return {
        "colour": np.broadcast_to(shade[:, None], (2, HEIGHT, WIDTH, 3)).copy(), "depth": depth,
        "classes": np.zeros((2, HEIGHT, WIDTH), np.uint8), "lens": np.tile(np.float32([FOCAL, 0.5, 9 / 32]), (2, 1)),
        "extrinsics": extrinsics.astype(np.float32), "root": np.round(root / ROOT_UNIT).astype(np.int16),
        "rotations": np.round(rotations * 32767).astype(np.int16), "labels": np.ones((WINDOWS, 66), np.uint8),
        "body": np.zeros(WINDOWS, np.int32),
        "rest": skeleton.default_rest_joints()[None, :22].astype(np.float32), "pairs": np.array(pairs, np.int32),
        "heights": heights, "corners": np.full((1, 2), -2.0, np.float32), "room_of_picture": np.zeros(2, np.int32),
    }  # fmt: skip
