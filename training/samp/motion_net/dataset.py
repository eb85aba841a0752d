"""Features of the training set: states and targets of every frame, cached as float16 memory maps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from scipy.ndimage import gaussian_filter1d

from ....models import state
from ....samp_addon import rotation, skeleton

SMOOTH_PATH = 10.0  # frames, standard deviation


BED_HALF = 0.5  # metres


@dataclass
class Dataset:
    """states, targets: (N, 647) float16; target is the next frame in the root frame of this one (N, 647).

    roots: (N, 3). sequence: (N,) number of the sequence. kinds: (S,). pieces: (S,). placements: (S, 3).
    usable, seated_goal: (N,). centres (P, 512, 3), occupancy (P, 512). goal_distance: (N,) metres on the floor from
    the root to the goal in force; from a lying place BED_HALF is taken off, since its edge comes first.
    """

    states: np.ndarray
    targets: np.ndarray
    roots: torch.Tensor
    sequence: np.ndarray
    kinds: np.ndarray
    pieces: np.ndarray
    placements: np.ndarray
    usable: np.ndarray
    centres: torch.Tensor
    occupancy: torch.Tensor
    seated_goal: np.ndarray
    goal_distance: np.ndarray

    def starts(self, window: int) -> np.ndarray:
        """Frames from which ``window`` steps stay in one sequence and in usable frames."""
        count = len(self.usable)
        total = np.concatenate([[0], np.cumsum(self.usable)])
        at = np.arange(count - window)
        whole = total[at + window] - total[at] == window
        return at[whole & (self.sequence[at] == self.sequence[at + window])]

    def object_features(self, frames: np.ndarray) -> torch.Tensor:
        """(B, 2048) of the object in the root frames of these frames; zero without an object."""
        number = self.sequence[frames]
        piece = torch.as_tensor(self.pieces[number])
        place = torch.as_tensor(self.placements[number])
        centres = self.centres[piece.clamp(min=0)]
        turned = state.turn3(centres, place[:, 2:].expand(centres.shape[:2]))
        world = turned + torch.stack([place[:, 0], torch.zeros(len(place)), place[:, 1]], -1)[:, None]
        features = state.interaction_features(world, self.occupancy[piece.clamp(min=0)], self.roots[frames])
        wanted = (piece >= 0) & torch.as_tensor(self.seated_goal[frames])
        return features * wanted[:, None]


def _sequence_arrays(root: np.ndarray, quats: np.ndarray) -> tuple[torch.Tensor, ...]:
    """World joints (T, 22, 3), axes (T, 22, 2, 3), velocities (T, 22, 3) and roots (T, 3)."""
    joints, turned = skeleton.forward_kinematics(root, quats, skeleton.default_rest_joints())
    matrix = rotation.quaternion_to_matrix(turned)
    axes = np.stack([matrix[..., 2], matrix[..., 1]], -2)
    velocity = np.zeros_like(joints)
    velocity[1:] = (joints[1:] - joints[:-1]) * state.FPS
    velocity[0] = velocity[min(1, len(velocity) - 1)]
    tensor = lambda a: torch.as_tensor(a, dtype=torch.float32)
    joints = tensor(joints)
    roots = torch.stack([joints[:, 0, 0], joints[:, 0, 2], state.heading_yaw(joints)], -1)
    return joints, tensor(axes), tensor(velocity), roots


def smooth_path(roots: torch.Tensor) -> torch.Tensor:
    """Roots (T, 3) without the sway of single steps: what a path that somebody plans can know of the future.

    The true future tells, by its sway, when each foot will come down. Nothing does at run time, and legs that have
    learnt to listen to it then fall asleep.
    """
    told = np.column_stack([roots[:, :2], np.unwrap(roots[:, 2])])
    return torch.as_tensor(gaussian_filter1d(told, SMOOTH_PATH, axis=0, mode="nearest"), dtype=roots.dtype)


def encode_sequence(
    root: np.ndarray, quats: np.ndarray, actions: np.ndarray, contacts: np.ndarray, goal: np.ndarray,
    goal_action: np.ndarray,
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:  # fmt: skip
    """States (T, 647), targets (T, 647) (the next frame in this frame's root frame; the last repeats) and roots."""
    joints, axes, velocity, roots = _sequence_arrays(root, quats)
    planned = smooth_path(roots)
    count = len(root)
    ahead_of_now = torch.as_tensor(state.SAMPLE_OFFSETS > 0)[:, None]
    tensor = lambda a: torch.as_tensor(np.ascontiguousarray(a), dtype=torch.float32)
    goals = torch.cat([tensor(goal), torch.eye(5)[torch.as_tensor(goal_action.astype(np.int64))]], -1)
    actions, contacts = tensor(actions), tensor(contacts)

    def told(frames: np.ndarray, reference: np.ndarray) -> torch.Tensor:
        window = np.clip(frames[:, None] + state.SAMPLE_OFFSETS, 0, count - 1)
        # The future of the goals is unknown at run time: it is taken to stay what it is.
        known = np.minimum(window, reference[:, None])
        ahead = np.minimum(frames + state.FPS, count - 1)
        path = torch.where(ahead_of_now, planned[window], roots[window])
        return state.assemble(
            roots[reference], joints[frames], axes[frames], velocity[frames], planned[ahead], path,
            actions[window], contacts[frames], goals[reference, :6], goals[known],
        )  # fmt: skip

    now = np.arange(count)
    following = np.minimum(now + 1, count - 1)
    return told(now, now), told(following, now), roots


def load(path: Path, cache: Path) -> Dataset:
    """The training set of prepare.py with its features, computed once into ``cache``."""
    with np.load(path) as data:
        raw = {name: data[name] for name in data.files}
    lengths = raw["lengths"]
    total = int(lengths.sum())
    cache.mkdir(parents=True, exist_ok=True)
    ready = (cache / "ready").exists()
    mode = "r" if ready else "w+"
    states = np.memmap(cache / "states.f16", np.float16, mode, shape=(total, state.SIZE))
    targets = np.memmap(cache / "targets.f16", np.float16, mode, shape=(total, state.SIZE))
    roots = np.memmap(cache / "roots.f32", np.float32, mode, shape=(total, 3))
    bounds = np.concatenate([[0], np.cumsum(lengths)])
    usable = ~raw["bad"].copy()
    for k, (a, b) in enumerate(zip(bounds[:-1], bounds[1:], strict=True)):
        if not ready:
            quats = rotation.normalise(raw["rotations"][a:b] / 32767.0)
            states[a:b], targets[a:b], roots[a:b] = encode_sequence(
                raw["root"][a:b].astype(np.float64), quats, raw["actions"][a:b], raw["contacts"][a:b],
                raw["goal"][a:b], raw["goal_action"][a:b],
            )  # fmt: skip
        open_start, open_end = raw["open_ends"][k]
        usable[a : a + 25 * int(open_start)] = False
        usable[max(a, b - 1 - 30 * int(open_end)) : b] = False
    if not ready:
        (cache / "ready").touch()
    return Dataset(
        states, targets, torch.as_tensor(np.array(roots)), np.repeat(np.arange(len(lengths)), lengths),
        raw["kinds"], raw["pieces"], raw["placements"], usable,
        torch.as_tensor(raw["piece_centres"]), torch.as_tensor(raw["piece_occupancy"]), raw["goal_action"] >= 3,
        np.linalg.norm(np.array(roots)[:, :2] - raw["goal"][:, [0, 2]], axis=-1)
        - BED_HALF * (raw["goal_action"] == 4),
    )  # fmt: skip
