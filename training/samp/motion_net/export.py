"""Turns a checkpoint's averaged weights into models/weights/motion_net.safetensors, with start poses.

python -m samp_blender.training.samp.motion_net.export --work RUN_FOLDER --mocap FOLDER ...
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import torch

from ....models import weights
from ....models.motion_net import ENCODER
from ....samp_addon import rotation, skeleton
from ....samp_addon.methods.start_poses import hands_hang
from ...mocap import clip_files, sources
from ...mocap.posture import neutralised

START_POSES = 12
_UPRIGHT = 0.97  # cosine
_QUIET = 0.05  # m/s that the pelvis may move in a start pose


def start_poses(folders: list[Path], seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Pelvis heights (K,) and local quaternions (K, 22, 4) of quiet upright standing, from different clips."""
    heights, poses = [], []
    clips = [clip for clip in neutralised(sources.load(folders)) if sources.walks(clip)]
    for k in np.random.default_rng(seed).permutation(len(clips)):
        clip = clips[k]
        speed = (
            np.linalg.norm(np.gradient(clip.root, 1 / clip_files.FPS, axis=0), axis=-1)
            if len(clip) > 2
            else [9]
        )
        upright = _upright(clip)
        still = (
            upright
            & (clip.labels == "idle")
            & (speed < _QUIET)
            & (clip.feet.min(1) > 0)
            & (clip.root[:, 1] > 0.9)
            & hands_hang(clip.rotations)
        )
        if still.any():
            frame = int(np.flatnonzero(still)[still.sum() // 2])
            heights.append(clip.root[frame, 1])
            poses.append(clip.rotations[frame])
        if len(poses) == START_POSES:
            break
    return np.array(heights), np.array(poses)


def _upright(clip: clip_files.Clip) -> np.ndarray:
    """Frames (T,) in which chest and head are upright: a slouch at the start stays for the whole way."""
    _, turned = skeleton.forward_kinematics(clip.root, clip.rotations, skeleton.default_rest_joints())
    up = rotation.quaternion_to_matrix(turned[:, [skeleton.INDEX["spine3"], skeleton.INDEX["head"]]])[
        ..., 1, 1
    ]
    return (up > _UPRIGHT).all(1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--mocap", type=Path, nargs="+", required=True)
    parser.add_argument("--folder", type=Path, default=weights.FOLDER)
    parser.add_argument(
        "--encoder", type=Path, help="folder for the encoder, with which a training can begin"
    )
    parser.add_argument("--last", action="store_true", help="the last weights, not their running average")
    options = parser.parse_args()
    body = torch.load(options.work / "checkpoint.pt", map_location="cpu", weights_only=True)
    buffers = ("input_", "target_", "object_", "posture_", "held", "goal_grid", "style_")
    tensors = {k: v for k, v in body["net"].items() if k.startswith(buffers)}
    learnt = body["net" if options.last else "average"]
    tensors |= {k: v for k, v in learnt.items() if k.startswith("decoder.")}
    heights, poses = start_poses(options.mocap)
    tensors |= {"start_heights": torch.as_tensor(heights), "start_rotations": torch.as_tensor(poses)}
    path = weights.save_weights("motion_net", tensors, options.folder)
    if options.encoder:
        encoder = {k: v for k, v in learnt.items() if k.startswith(ENCODER)}
        weights.save_weights("encoder", encoder, options.encoder)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB after {body['step']} steps")


if __name__ == "__main__":
    main()
