"""Clips of a gliding body that stands, walks, bends its way and turns: enough for walks to be matched."""

import numpy as np
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.easing import smoothstep
from samp_blender.training.mocap.clip_files import FPS, Clip
from samp_blender.training.rooms.episodes import bank


def gliding(name, speed, turn, label=None):
    """A clip whose root moves at speed (T,) m/s along its facing, which turns at (T,) rad/s."""
    yaw = np.cumsum(turn) / FPS
    step = speed[:, None] * np.stack([np.sin(yaw), np.zeros_like(yaw), np.cos(yaw)], -1) / FPS
    root = np.cumsum(step, axis=0) + [0.0, 0.93, 0.0]
    quats = np.zeros((len(root), 22, 4))
    quats[..., 0] = 1
    quats[:, 0] = rotation.about_y(yaw)
    labels = (
        np.where((speed > 0.1) | (np.abs(turn) > 0.1), "walk", "idle")
        if label is None
        else np.full(len(root), label)
    )
    return Clip(name, root, quats, labels, np.zeros((len(root), 2)), np.zeros(len(root), bool))


def small_bank():
    """A bank of straight walks, starts, stops, bends and turns on the spot."""
    time = np.arange(240) / FPS
    clips = [gliding("stand", 0 * time, 0 * time)]
    for pace in (0.5, 0.8, 1.1):
        hump = pace * smoothstep((time - 1.5) / 0.8) * smoothstep((6.0 - time) / 0.8)
        for turn in (-0.8, -0.4, 0.0, 0.4, 0.8):
            clips.append(gliding(f"walk{pace}{turn}", hump, turn * hump / pace))
    for turn in (-1.5, 1.5):
        spin = turn * smoothstep((time - 1.5) / 0.5) * smoothstep((6.0 - time) / 0.5)
        clips.append(gliding(f"turn{turn}", 0 * time, spin))
    return bank.build(clips)
