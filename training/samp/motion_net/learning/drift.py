"""Rollouts that are not quite where the captured motion is: what they see of the world, and how they come back.

A *drift* (B, 3) is the root of a rollout told in the frame of the captured root: x, z, yaw. Its own body and past
move with it; the goal, the furniture and the planned path stay in the world. Walking brings a body back to the path:
of a drift, exp(-way / RETURN) is left after a way.
"""

from __future__ import annotations

import torch

from .....models import state

RETURN = 0.8  # metres of way after which a third of a drift is left
TURN_LENGTH = 0.15  # metres of way that a turn by one radian counts as
AHEAD = slice(state.NOW + 1, None)


def between(own: torch.Tensor, captured: torch.Tensor) -> torch.Tensor:
    """Drifts (B, 3) of roots ``own`` (B, 3) from ``captured`` ones (B, 3)."""
    turn = torch.remainder(own[:, 2] - captured[:, 2] + torch.pi, 2 * torch.pi) - torch.pi
    return torch.cat([state.flat_to_root(own[:, :2], captured), turn[:, None]], -1)


def moved(roots: torch.Tensor, step: torch.Tensor) -> torch.Tensor:
    """Roots (B, 3) that went on by steps (B, 3), told in their own frames."""
    return torch.cat([roots[:, :2] + state.turn(step[:, :2], roots[:, 2]), roots[:, 2:] + step[:, 2:]], -1)


def step_of(states: torch.Tensor) -> torch.Tensor:
    """By how much the roots of states (B, 647) went on (B, 3): nothing in a state, something in a prediction."""
    now = states[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW]
    return torch.cat([now[:, :2], torch.atan2(now[:, 2], now[:, 3])[:, None]], -1)


def ways(path: torch.Tensor) -> torch.Tensor:
    """Metres (B, K) gone along paths (B, K, 3) from the origin, turns counted too."""
    steps = torch.diff(path, dim=1, prepend=torch.zeros_like(path[:, :1]))
    turns = torch.remainder(steps[..., 2] + torch.pi, 2 * torch.pi) - torch.pi
    return (steps[..., :2].norm(dim=-1) + TURN_LENGTH * turns.abs()).cumsum(1)


def seen_goals(states: torch.Tensor, drift: torch.Tensor) -> torch.Tensor:
    """The goals' numbers (B, 143) of states (B, 647), seen from drifted roots."""
    goals = states[:, state.GOAL].reshape(-1, state.SAMPLES, 11)
    turn = -drift[:, 2:].expand(-1, state.SAMPLES)
    seen = [state.to_root(goals[..., :3], drift), state.turn3(goals[..., 3:6], turn), goals[..., 6:]]
    return torch.cat(seen, -1).flatten(1)


def seen_path(states: torch.Tensor, drift: torch.Tensor, first: int) -> torch.Tensor:
    """Places and directions (B, K, 4) of the trajectory's samples from ``first`` on, as somebody drifted has to go to
    come back to them; told in the drifted frame."""
    samples = states[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, first:, :4]
    places = samples[..., :2]
    yaws = torch.atan2(samples[..., 2], samples[..., 3])
    left = torch.exp(-ways(torch.cat([places, yaws[..., None]], -1)) / RETURN)[..., None]
    back = left * places + (1 - left) * state.flat_to_root(places, drift)
    turn = -(1 - left[..., 0]) * drift[:, 2:]
    return torch.cat([back, state.turn(samples[..., 2:], turn)], -1)


def seen(states: torch.Tensor, drift: torch.Tensor) -> torch.Tensor:
    """States (B, 647) of captured frames as they are for somebody drifted, in the drifted root's frame."""
    out = states.clone()
    out[:, state.GOAL] = seen_goals(states, drift)
    path = out[:, state.TRAJECTORY].view(-1, state.SAMPLES, 9)
    path[:, AHEAD, :4] = seen_path(states, drift, state.NOW + 1)
    return state.consistent(out)


def followed(targets: torch.Tensor, drift: torch.Tensor) -> torch.Tensor:
    """What follows captured frames (B, 647), for somebody who has drifted and comes back on the way."""
    out = targets.clone()
    out[:, state.GOAL] = seen_goals(targets, drift)
    path = out[:, state.TRAJECTORY].view(-1, state.SAMPLES, 9)
    before = path[:, state.NOW, :4].clone()
    path[:, state.NOW :, :4] = seen_path(targets, drift, state.NOW)
    now = path[:, state.NOW, :4]
    yaw = lambda sample: torch.atan2(sample[:, 2], sample[:, 3])
    turn = yaw(now) - yaw(before)
    pose = out[:, state.POSE].view(-1, state.JOINTS, 4, 3)
    # The body goes along with its root.
    from_root = torch.zeros_like(pose)
    from_root[:, :, 0, 0::2] = before[:, None, :2]
    to_root = torch.zeros_like(pose)
    to_root[:, :, 0, 0::2] = now[:, None, :2]
    to_root[:, :, 3, 0::2] = ((now - before)[:, :2] * state.FPS)[:, None]
    pose.copy_(state.turn3(pose - from_root, turn[:, None, None].expand(pose.shape[:3])) + to_root)
    return state.consistent(out)
