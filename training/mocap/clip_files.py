"""Read and mirror the prepared motion capture (30 fps, 22 SMPL-X body joints, Y up).

The clips are not part of this repository; see docs/training.md for their sources and terms.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...samp_addon import rotation, skeleton

FPS = 30
MIRROR = skeleton.mirror_joints()


@dataclass(frozen=True)
class Clip:
    """A captured clip.

    root: (T, 3) pelvis, metres. rotations: (T, 22, 4) local quaternions (w, x, y, z). labels: (T,) names. feet: (T, 2)
    contact of right and left foot. bad: (T,) flags of frames with a pop in the source.
    """

    name: str
    root: np.ndarray
    rotations: np.ndarray
    labels: np.ndarray
    feet: np.ndarray
    bad: np.ndarray

    def __len__(self) -> int:
        return len(self.root)

    def cut(self, start: int, stop: int) -> Clip:
        """Return the frames start .. stop - 1."""
        part = slice(start, stop)
        return replace(
            self,
            root=self.root[part],
            rotations=self.rotations[part],
            labels=self.labels[part],
            feet=self.feet[part],
            bad=self.bad[part],
        )


def load_clip(path: Path) -> Clip:
    """Read one .npz of the prepared format."""
    with np.load(path) as data:
        heel_ball = data["contact"].astype(np.float64)  # left heel, left ball, right heel, right ball
        return Clip(
            name=path.stem,
            root=data["root_pos"].astype(np.float64),
            rotations=rotation.continuous(rotation.normalise(data["local_quat_wxyz"].astype(np.float64))),
            labels=data["label_names"][data["label"]].astype(str),
            feet=np.stack([heel_ball[:, 2:].max(1), heel_ball[:, :2].max(1)], -1),
            bad=data["glitch"].astype(bool),
        )


def load_clips(folder: Path) -> list[Clip]:
    """Read all clips of a folder, in the order of their names."""
    return [load_clip(path) for path in sorted(folder.glob("*.npz"))]


def mirror(clip: Clip) -> Clip:
    """Return the clip with left and right exchanged, mirrored in the plane x = 0."""
    turned = clip.rotations[:, MIRROR] * np.array([1.0, 1.0, -1.0, -1.0])
    return replace(
        clip,
        name=clip.name + "_mirror",
        root=clip.root * np.array([-1.0, 1.0, 1.0]),
        rotations=turned,
        feet=clip.feet[:, ::-1],
    )
