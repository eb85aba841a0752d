"""Motion, the common currency: methods return it; baking, refining, measuring and exporting take it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from . import rotation, skeleton


def velocities(positions: np.ndarray, fps: float) -> np.ndarray:
    """Return central differences (T, ...) of positions (T, ...) per second; zero for a single frame."""
    return np.gradient(positions, 1 / fps, axis=0) if len(positions) > 1 else np.zeros_like(positions)


@dataclass(frozen=True)
class Motion:
    """A take, in the network frame (metres, Y up, +Z forward; see frames.py).

    root: (T, 3) world position of the pelvis joint (not SMPL's ``trans``, which is this minus the rest pelvis).
    rotations: (T, J, 4) local joint rotations, quaternions w, x, y, z, in the order of skeleton.JOINTS; J is 22 or 55.
    contacts: (T, 5) from 0 to 1, in the order of vocabulary.CONTACTS. actions: (T, 5) weights, in that of ACTIONS.
    rest_joints: (J, 3) rest positions with the pelvis at the origin. fps: frames per second.
    interaction_start: frame index in which sitting or lying down begins, or None.
    """

    root: np.ndarray
    rotations: np.ndarray
    fps: float = 30.0
    contacts: np.ndarray | None = None
    actions: np.ndarray | None = None
    rest_joints: np.ndarray = field(default_factory=skeleton.default_rest_joints)
    interaction_start: int | None = None

    def __post_init__(self) -> None:
        frames = len(self.root)
        if self.root.shape != (frames, 3) or self.rotations.ndim != 3 or self.rotations.shape[0] != frames:
            raise ValueError(
                f"root {self.root.shape} and rotations {self.rotations.shape} do not fit together"
            )

    def __len__(self) -> int:
        return len(self.root)

    @property
    def seconds(self) -> float:
        """Length in seconds, from the first frame to the last."""
        return max(len(self) - 1, 0) / self.fps

    def forward_kinematics(self) -> tuple[np.ndarray, np.ndarray]:
        """Return world positions (T, J, 3) and global quaternions (T, J, 4) of the joints; cached, read-only."""
        return self._kinematics

    def headings(self) -> np.ndarray:
        """Return the horizontal unit facing (T, 3): the mean of hip and shoulder line, crossed with up."""
        joints, _ = self.forward_kinematics()
        side = {
            name: skeleton.INDEX[name]
            for name in ("left_hip", "right_hip", "left_shoulder", "right_shoulder")
        }
        across = joints[:, side["left_hip"]] - joints[:, side["right_hip"]]
        across = across + joints[:, side["left_shoulder"]] - joints[:, side["right_shoulder"]]
        facing = np.cross(across, [0.0, 1.0, 0.0])
        return facing / np.maximum(np.linalg.norm(facing, axis=-1, keepdims=True), 1e-9)

    @cached_property
    def _kinematics(self) -> tuple[np.ndarray, np.ndarray]:
        result = skeleton.forward_kinematics(self.root, self.rotations, self.rest_joints)
        for values in result:
            values.setflags(write=False)
        return result

    def pose_slice(self, rows: slice | np.ndarray) -> Motion:
        """Return the poses of some frames, without contacts, actions and interaction."""
        return Motion(self.root[rows], self.rotations[rows], self.fps, rest_joints=self.rest_joints)

    def picked(self, rows: np.ndarray) -> Motion:
        """Return the frames with these numbers (N,), in their order, with contacts and actions, without interaction."""
        pick = lambda values: None if values is None else values[rows]
        return replace(self.pose_slice(rows), contacts=pick(self.contacts), actions=pick(self.actions))

    def resampled(self, fps: float) -> Motion:
        """Resample to another frame rate: linear for positions, slerp for rotations; the last frame is kept."""
        if abs(fps - self.fps) < 1e-9 or len(self) < 2:
            return replace(self, fps=fps)
        count = max(int(round(self.seconds * fps)) + 1, 2)
        start = self.interaction_start
        return replace(
            self.at_frames(np.arange(count) * self.fps / fps),
            fps=fps,
            interaction_start=None if start is None else min(int(round(start * fps / self.fps)), count - 1),
        )

    def at_frames(self, frames: np.ndarray) -> Motion:
        """Return the motion at rising frames (N,) with fractions: linear for positions, slerp for rotations."""
        at = np.clip(frames, 0, len(self) - 1)
        low = np.minimum(at.astype(int), max(len(self) - 2, 0))
        high, t = np.minimum(low + 1, len(self) - 1), at - low
        mix = lambda a: None if a is None else a[low] * (1 - t[:, None]) + a[high] * t[:, None]
        first = self.interaction_start
        return replace(
            self,
            root=mix(self.root),
            rotations=rotation.slerp(self.rotations[low], self.rotations[high], t[:, None]),
            contacts=mix(self.contacts),
            actions=mix(self.actions),
            interaction_start=None
            if first is None
            else min(int(np.searchsorted(at, first - 1e-6)), len(at) - 1),
        )

    def smoothed(self, sigma: float) -> Motion:
        """Smooth root and rotations over time with a Gaussian; sigma in frames. Contacts and actions are unchanged."""
        from scipy.ndimage import gaussian_filter1d  # slow to import; this module is loaded at registration

        quats = gaussian_filter1d(rotation.continuous(self.rotations), sigma, axis=0, mode="nearest")
        root = gaussian_filter1d(self.root, sigma, axis=0, mode="nearest")
        return replace(self, root=root, rotations=rotation.normalise(quats))


@dataclass(frozen=True)
class Goal:
    """Where the pelvis ends, in the network frame.

    position: (3,) of the pelvis joint, metres; direction: (3,) unit, horizontal.
    """

    position: np.ndarray
    direction: np.ndarray
    action: str = "sit"
