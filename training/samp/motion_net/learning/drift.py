"""Rollouts off the captured path: their observations and the targets that lead them back.

A drift (B, 3) is the root of a rollout in the frame of the captured root: x, z (metres) and yaw (radians). The body and
its past move with the root; goal, furniture and planned path stay in the world. Walking leads a body back to the path:
after a path length s, the drift has decayed to exp(-s / length) of itself. The length is RETURN, and shorter in front
of a seat or bed: a body that sits down has only some decimetres of path left, and would end beside its goal.
"""

from __future__ import annotations

import torch

from .....models import state

RETURN = 0.8  # metres of path over which a drift decays by a factor of e
NEAR_RETURN = 0.25  # the same, close to a seat or bed
NEAR, FAR = 0.6, 1.5  # metres to the goal between which the one passes into the other
TURN_LENGTH = 0.15  # metres of path equivalent to a turn by one radian
AHEAD = slice(state.NOW + 1, None)


def offset(own: torch.Tensor, captured: torch.Tensor) -> torch.Tensor:
    """Return the drifts (B, 3) of roots ``own`` (B, 3) relative to ``captured`` ones (B, 3)."""
    turn = torch.remainder(own[:, 2] - captured[:, 2] + torch.pi, 2 * torch.pi) - torch.pi
    return torch.cat([state.flat_to_root(own[:, :2], captured), turn[:, None]], -1)


def displace(roots: torch.Tensor, step: torch.Tensor) -> torch.Tensor:
    """Return roots (B, 3) displaced by steps (B, 3), which are in the frames of the roots."""
    return torch.cat([roots[:, :2] + state.turn(step[:, :2], roots[:, 2]), roots[:, 2:] + step[:, 2:]], -1)


def root_step(states: torch.Tensor) -> torch.Tensor:
    """Return the root displacement (B, 3) of predictions (B, 647); zero for the state of a present frame."""
    now = states[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW]
    return torch.cat([now[:, :2], torch.atan2(now[:, 2], now[:, 3])[:, None]], -1)


def return_lengths(distance: torch.Tensor, seated: torch.Tensor) -> torch.Tensor:
    """Return the lengths of path (B, 1), metres, over which drifts decay by a factor of e.

    distance: (B,) metres to the goal. seated: (B,) whether the goal is a seat or bed.
    """
    away = ((distance - NEAR) / (FAR - NEAR)).clamp(0, 1).masked_fill(~seated, 1.0)
    return (NEAR_RETURN + away * (RETURN - NEAR_RETURN))[:, None]


def path_lengths(path: torch.Tensor) -> torch.Tensor:
    """Return the lengths (B, K), metres, of paths (B, K, 3) from the origin to each sample; turns add TURN_LENGTH."""
    steps = torch.diff(path, dim=1, prepend=torch.zeros_like(path[:, :1]))
    turns = torch.remainder(steps[..., 2] + torch.pi, 2 * torch.pi) - torch.pi
    return (steps[..., :2].norm(dim=-1) + TURN_LENGTH * turns.abs()).cumsum(1)


def observe_goals(states: torch.Tensor, drift: torch.Tensor) -> torch.Tensor:
    """Return the goal features (B, 143) of states (B, 647) in the frames of drifted roots."""
    goals = states[:, state.GOAL].reshape(-1, state.SAMPLES, 11)
    turn = -drift[:, 2:].expand(-1, state.SAMPLES)
    seen = [state.to_root(goals[..., :3], drift), state.turn3(goals[..., 3:6], turn), goals[..., 6:]]
    return torch.cat(seen, -1).flatten(1)


def observe_path(states: torch.Tensor, drift: torch.Tensor, first: int, length: torch.Tensor) -> torch.Tensor:
    """Return positions and directions (B, K, 4) of a path that leads from drifted roots back to the captured one.

    first: index of the first trajectory sample. length: (B, 1), see return_lengths. The result is in the frames of the
    drifted roots.
    """
    samples = states[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, first:, :4]
    places = samples[..., :2]
    yaws = torch.atan2(samples[..., 2], samples[..., 3])
    left = torch.exp(-path_lengths(torch.cat([places, yaws[..., None]], -1)) / length)[..., None]
    back = left * places + (1 - left) * state.flat_to_root(places, drift)
    turn = -(1 - left[..., 0]) * drift[:, 2:]
    return torch.cat([back, state.turn(samples[..., 2:], turn)], -1)


def observe(states: torch.Tensor, drift: torch.Tensor, length: torch.Tensor) -> torch.Tensor:
    """Return the states (B, 647) of captured frames as observed from drifted roots, in the frames of those.

    length: (B, 1), see return_lengths.
    """
    out = states.clone()
    out[:, state.GOAL] = observe_goals(states, drift)
    path = out[:, state.TRAJECTORY].view(-1, state.SAMPLES, 9)
    path[:, AHEAD, :4] = observe_path(states, drift, state.NOW + 1, length)
    return state.consistent(out)


def correct(targets: torch.Tensor, drift: torch.Tensor, length: torch.Tensor) -> torch.Tensor:
    """Return targets (B, 647) for drifted roots: the captured ones, led back towards the captured path.

    length: (B, 1), see return_lengths.
    """
    out = targets.clone()
    out[:, state.GOAL] = observe_goals(targets, drift)
    path = out[:, state.TRAJECTORY].view(-1, state.SAMPLES, 9)
    before = path[:, state.NOW, :4].clone()
    path[:, state.NOW :, :4] = observe_path(targets, drift, state.NOW, length)
    now = path[:, state.NOW, :4]
    yaw = lambda sample: torch.atan2(sample[:, 2], sample[:, 3])
    turn = yaw(now) - yaw(before)
    pose = out[:, state.POSE].view(-1, state.JOINTS, 4, 3)
    # The body moves with its root.
    from_root = torch.zeros_like(pose)
    from_root[:, :, 0, 0::2] = before[:, None, :2]
    to_root = torch.zeros_like(pose)
    to_root[:, :, 0, 0::2] = now[:, None, :2]
    to_root[:, :, 3, 0::2] = ((now - before)[:, :2] * state.FPS)[:, None]
    pose.copy_(state.turn3(pose - from_root, turn[:, None, None].expand(pose.shape[:3])) + to_root)
    return state.consistent(out)
