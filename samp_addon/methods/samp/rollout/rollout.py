"""The rollout of MotionNet: frame by frame, a batch of takes, with control of the root's future path.

The floor is at height 0; heights are added afterwards. See models/state.py for the layout of the state.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch

from .....models import state
from .....models.motion_net import LATENT, MotionNet
from .... import skeleton
from .start import Start

FUTURE = state.SAMPLES - state.NOW - 1
# Standard deviation, in training, of the components of z that are drawn every frame. Those held for a whole take have
# 1 there, so that they are scaled by the style relative to this.
FRAME_NOISE = 0.1
# Sum of the differences between shares of postures up to which a style fits a take as well as the best one.
POSTURE_TOLERANCE = 0.5
GOAL_PULL = (
    100.0  # how fast the prediction in the goal's frame outweighs the one in the root's frame near the goal
)
_PARENTS = torch.as_tensor(skeleton.PARENTS[1 : state.JOINTS])
_PER_TAKE = (
    "style", "held_z", "centres", "occupancy", "postures", "joints", "matrices", "velocities", "contacts", "past_roots",
    "past_actions", "past_goals", "roots", "future_roots", "future_actions",
)  # fmt: skip


class Guide(Protocol):
    """Guidance of a rollout. Without a guide everything is left to the network."""

    def steer(self, roots: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return shift (B, 2) and turn (B,) of the bodies with new roots (B, 3)."""

    def follow(self, future: torch.Tensor, roots: torch.Tensor) -> torch.Tensor:
        """Return the future path (B, 6, 3) for the predicted one (B, 6, 3)."""

    def intend(self, future: torch.Tensor) -> torch.Tensor:
        """Return the future actions (B, 6, 5) for the predicted ones (B, 6, 5)."""


@dataclass
class Frame:
    """One generated frame of B takes: pelvis (B, 3), global rotation matrices (B, 22, 3, 3), contacts (B, 5),
    actions (B, 5), roots (B, 3)."""

    pelvis: torch.Tensor
    matrices: torch.Tensor
    contacts: torch.Tensor
    actions: torch.Tensor
    roots: torch.Tensor


class Rollout:
    """B takes in progress. Call set_goals, then step, once per frame."""

    def __init__(
        self,
        net: MotionNet,
        starts: list[Start],
        centres: torch.Tensor,
        occupancy: torch.Tensor,
        seeds: list[int],
        style: torch.Tensor,
        actions: torch.Tensor,
        postures: torch.Tensor | None = None,
    ) -> None:
        """centres: (B, 512, 3), world, and occupancy: (B, 512) of the objects. style: (B, 1) deviation of z.

        actions: (B,) indices of the takes' actions. postures: (B, 9) of the rests, for networks that know them.
        """
        self.net, self.style = net, style
        self.postures = (
            torch.zeros(len(starts), net.postures) if postures is None else postures[:, : net.postures]
        )
        self.centres, self.occupancy = centres, occupancy
        self.generators = [torch.Generator().manual_seed(int(seed)) for seed in seeds]
        self.held_z = self._draw_held(actions) * style / FRAME_NOISE
        rest = torch.tensor(skeleton.default_rest_joints()[: state.JOINTS], dtype=torch.float32)
        self.bones = torch.stack([rest[j] - rest[max(skeleton.PARENTS[j], 0)] for j in range(state.JOINTS)])
        stacked = lambda name: torch.stack([getattr(start, name) for start in starts])
        self.joints, self.matrices, self.velocities = map(stacked, ("joints", "matrices", "velocities"))
        self.contacts, self.past_roots, self.past_actions = map(stacked, ("contacts", "roots", "actions"))
        self.roots = self.past_roots[:, -1].clone()
        self.past_goals: torch.Tensor | None = None
        self.future_roots = self.roots[:, None].repeat(1, FUTURE, 1)
        self.future_actions = self.past_actions[:, -1:].repeat(1, FUTURE, 1)

    def _forward(self, pelvis: torch.Tensor, matrices: torch.Tensor) -> torch.Tensor:
        """Return the world joints (B, 22, 3) of pelvis (B, 3) and global matrices (B, 22, 3, 3)."""
        # In numpy, since its calls cost less time than torch's on such small arrays.
        arms = (matrices[:, _PARENTS] @ self.bones[1:, :, None])[..., 0].detach().numpy()
        joints = np.empty((len(pelvis), state.JOINTS, 3), np.float32)
        joints[:, 0] = pelvis.detach().numpy()
        for j in range(1, state.JOINTS):
            joints[:, j] = joints[:, skeleton.PARENTS[j]] + arms[:, j - 1]
        return torch.from_numpy(joints)

    def select(self, rows: torch.Tensor) -> Rollout:
        """Return the rollout of some of the takes."""
        part = copy(self)
        for name in _PER_TAKE:
            setattr(part, name, getattr(self, name)[rows])
        part.generators = [self.generators[int(row)] for row in rows]
        return part

    @property
    def actions(self) -> torch.Tensor:
        """Return the action weights (B, 5) of the present frame."""
        return self.past_actions[:, -1]

    def set_goals(self, goals: torch.Tensor) -> None:
        """Set the goals in force (B, 11): position 3, direction 3, action 5."""
        if self.past_goals is None:
            self.past_goals = goals[:, None].repeat(1, self.past_roots.shape[1], 1)
        else:
            self.past_goals = torch.cat([self.past_goals[:, 1:], goals[:, None]], 1)

    def set_path(self, future: np.ndarray) -> None:
        """Set the future path (B, 6, 3) that the network sees in the next frame: x, z, yaw."""
        self.future_roots = torch.as_tensor(future, dtype=torch.float32)

    def _input(self) -> torch.Tensor:
        """Return the state (B, 647) of the present frame, in its own root frame."""
        sampled = slice(0, None, state.SAMPLE_STRIDE)
        goals = self.past_goals[:, -1]
        axes = torch.stack([self.matrices[..., 2], self.matrices[..., 1]], -2)
        return state.assemble(
            self.roots, self.joints, axes, self.velocities, self.future_roots[:, -1],
            torch.cat([self.past_roots[:, sampled], self.future_roots], 1),
            torch.cat([self.past_actions[:, sampled], self.future_actions], 1),
            self.contacts, goals[:, :6],
            torch.cat([self.past_goals[:, sampled], goals[:, None].expand(-1, FUTURE, -1)], 1),
        )  # fmt: skip

    def _object(self) -> torch.Tensor:
        """Return the features (B, 2048 + postures) of objects; zero while the goal in force is not on an object."""
        wanted = self.past_goals[:, -1, 9:11].sum(-1, keepdim=True)
        if not wanted.any():
            return torch.zeros(len(wanted), 4 * self.centres.shape[1] + self.postures.shape[1])
        seen = state.interaction_features(self.centres, self.occupancy, self.roots)
        return torch.cat([seen, self.postures], -1) * wanted

    def step(self, guide: Guide | None = None) -> Frame:
        """Generate the next frame of every take."""
        x = self._input()
        held = self.held_z.shape[1]
        z = torch.cat([self.held_z, self._noise(LATENT - held) * self.style], 1)
        y = self.net.step(x, self._object(), z)
        self._advance(y, guide)
        return Frame(self.joints[:, 0], self.matrices, self.contacts, self.actions, self.roots)

    def _draw_held(self, actions: torch.Tensor) -> torch.Tensor:
        """Return the held components of z (B, held): codes of real motion of the actions (B,), or N(0, 1) without.

        A code is drawn among those of people who rested in a take's posture, or in the one most like it: the code says
        how a body rests as well, and against it a posture is hardly seen.
        """
        held, codes = int(self.net.held), self.net.style_codes
        if not bool(codes.any()):
            return self._noise(held)
        drawn = []
        for action, posture, generator in zip(actions, self.postures, self.generators, strict=True):
            apart = torch.zeros(codes.shape[1])
            if bool(posture.any()):
                apart = (self.net.style_postures[action].float() - posture).abs().sum(-1)
            fitting = torch.nonzero(apart <= apart.min() + POSTURE_TOLERANCE)[:, 0]
            drawn.append(codes[action, fitting[torch.randint(len(fitting), (), generator=generator)], :held])
        return torch.stack(drawn)

    def _noise(self, count: int) -> torch.Tensor:
        """Return normal random numbers (B, count), drawn from the generator of each take."""
        return torch.stack([torch.randn(count, generator=g) for g in self.generators])

    def _advance(self, y: torch.Tensor, guide: Guide | None) -> None:
        """Advance the state by a prediction y of the network, in the frame of the previous roots."""
        before = self.roots
        pose = y[:, state.POSE].reshape(-1, state.JOINTS, 4, 3)
        trajectory = y[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)
        positions = state.turn(trajectory[..., 0:2], before[:, 2:]) + before[:, None, :2]
        yaws = torch.atan2(trajectory[..., 2], trajectory[..., 3]) + before[:, 2:]
        window = torch.cat([positions, yaws[..., None]], -1)
        self.roots = window[:, state.NOW]
        self._pose(pose, before)
        weights = trajectory[..., 4:].clamp(0, 1)
        self.contacts = y[:, state.CONTACTS].clamp(0, 1)
        future = window[:, state.NOW + 1 :]
        if guide is not None:
            future = self._nudge(*guide.steer(self.roots), future)
        future, actions = self._towards_goal(future, y), weights[:, state.NOW + 1 :]
        self.future_roots = guide.follow(future, self.roots) if guide else future
        self.future_actions = guide.intend(actions) if guide else actions
        self.past_roots = torch.cat([self.past_roots[:, 1:], self.roots[:, None]], 1)
        self.past_actions = torch.cat([self.past_actions[:, 1:], weights[:, state.NOW : state.NOW + 1]], 1)

    def _nudge(self, shift: torch.Tensor, angle: torch.Tensor, future: torch.Tensor) -> torch.Tensor:
        """Shift the bodies by (B, 2) and turn them by (B,) about their roots. Return the future paths, moved along."""
        pivot = self.roots[:, :2].clone()
        corner = torch.stack([pivot[:, 0], torch.zeros_like(angle), pivot[:, 1]], -1)
        offset = torch.stack([shift[:, 0], torch.zeros_like(angle), shift[:, 1]], -1)
        about = _about_y(angle)
        self.matrices = about[:, None] @ self.matrices
        self.joints = (self.joints - corner[:, None]) @ about.mT + (corner + offset)[:, None]
        self.velocities = self.velocities @ about.mT
        self.roots = torch.cat([pivot + shift, self.roots[:, 2:] + angle[:, None]], -1)
        places = state.turn(future[..., :2] - pivot[:, None], angle[:, None]) + (pivot + shift)[:, None]
        return torch.cat([places, future[..., 2:] + angle[:, None, None]], -1)

    def _pose(self, pose: torch.Tensor, before: torch.Tensor) -> None:
        """Set joints, matrices and velocities from the predicted pose, given in the frame of the previous roots."""
        world = state.turn3(pose, before[:, 2, None, None])
        pelvis = world[:, 0, 0] + state.on_floor(before)
        self.velocities = world[:, :, 3]
        forward = torch.nn.functional.normalize(world[:, :, 1], dim=-1)
        up = world[:, :, 2]
        up = torch.nn.functional.normalize(up - (up * forward).sum(-1, keepdim=True) * forward, dim=-1)
        self.matrices = torch.stack([torch.linalg.cross(up, forward), up, forward], -1)
        integrated = self.joints[:, 0] + self.velocities[:, 0] / state.FPS
        self.joints = self._forward((pelvis + integrated) / 2, self.matrices)

    def _towards_goal(self, future: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
        """Blend the predicted path (B, 6, 3) with the one predicted in the goal's frame, more so near the goal."""
        goal = self.past_goals[:, -1]
        yaw = torch.atan2(goal[:, 3], goal[:, 5])[:, None]
        relative = y[:, state.GOAL_TRAJECTORY].reshape(-1, state.SAMPLES, 4)[:, state.NOW + 1 :]
        positions = state.turn(relative[..., :2], yaw) + goal[:, None, [0, 2]]
        facing = torch.atan2(relative[..., 2], relative[..., 3]) + yaw
        squared = (self.roots[:, :2] - goal[:, [0, 2]]).square().sum(-1, keepdim=True)
        share = torch.arange(1, FUTURE + 1) / (FUTURE + 1)
        weight = share[None] ** (GOAL_PULL * squared)
        mixed = future[..., :2] + weight[..., None] * (positions - future[..., :2])
        difference = torch.remainder(facing - future[..., 2] + np.pi, 2 * np.pi) - np.pi
        return torch.cat([mixed, (future[..., 2] + weight * difference)[..., None]], -1)


def _about_y(yaw: torch.Tensor) -> torch.Tensor:
    """Return the rotation matrices (B, 3, 3) of yaws (B,)."""
    c, s, o, i = torch.cos(yaw), torch.sin(yaw), torch.zeros_like(yaw), torch.ones_like(yaw)
    return torch.stack([c, o, s, o, i, o, -s, o, c], -1).reshape(-1, 3, 3)
