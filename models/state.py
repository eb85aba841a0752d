"""The 647 numbers of SAMP's state X (equation 1): their layout, and conversion between root frames.

All geometry is in the network frame (metres, Y up, +Z forward). A *root* is the pelvis projected onto the floor with
the yaw of the body's heading, stored as (x, z, yaw). Horizontal vectors are pairs (x, z).
"""

from __future__ import annotations

import numpy as np
import torch

JOINTS = 22
SAMPLES = 13  # trajectory samples over the window of -1 s .. +1 s
ACTIONS = 5  # idle, walk, run, sit, lie
NOW = SAMPLES // 2
SAMPLE_STRIDE = 5  # frames at 30 fps between samples
FPS = 30
SIZE = 647

POSE = slice(0, 264)  # joints x (position 3, forward 3, up 3, velocity 3), in the root frame
FUTURE = slice(264, 330)  # joints x position 3, in the frame of the root one second ahead
TRAJECTORY = slice(330, 447)  # samples x (position 2, direction 2, action 5), in the root frame
CONTACTS = slice(447, 452)  # pelvis, right hand, left hand, right foot, left foot
GOAL_TRAJECTORY = slice(452, 504)  # samples x (position 2, direction 2), in the goal's frame
GOAL = slice(504, 647)  # samples x (position 3, direction 3, action 5), in the root frame

SAMPLE_OFFSETS = (np.arange(SAMPLES) - NOW) * SAMPLE_STRIDE
_LEFT_RIGHT = (
    (1, 2),
    (16, 17),
)  # pairs of left and right joints that define the lateral direction: hips and shoulders


def heading_yaw(positions: torch.Tensor) -> torch.Tensor:
    """Return yaws (...,) of bodies with joints (..., 22, 3): mean of hip and shoulder line, crossed with up."""
    across = sum(positions[..., left, :] - positions[..., right, :] for left, right in _LEFT_RIGHT)
    # left x up = forward: (x, 0, z) x (0, 1, 0) = (-z, 0, x)
    return torch.atan2(-across[..., 2], across[..., 0])


def turn(vectors: torch.Tensor, yaw: torch.Tensor) -> torch.Tensor:
    """Rotate horizontal pairs (..., 2) by yaws, broadcast to (...), positive from +Z towards +X; radians."""
    c, s = torch.cos(yaw), torch.sin(yaw)
    x, z = vectors.unbind(-1)
    return torch.stack([c * x + s * z, c * z - s * x], dim=-1)


def turn3(vectors: torch.Tensor, yaw: torch.Tensor) -> torch.Tensor:
    """Rotate vectors (..., 3) about the vertical by yaws, broadcast to (...); radians."""
    c, s = torch.cos(yaw), torch.sin(yaw)
    x, y, z = vectors.unbind(-1)
    return torch.stack([c * x + s * z, y, c * z - s * x], dim=-1)


def to_root(points: torch.Tensor, root: torch.Tensor) -> torch.Tensor:
    """Express world points (N, ..., 3) in the frames of roots (N, 3)."""
    shape = (-1,) + (1,) * (points.dim() - 2)
    return turn3(points - on_floor(root).reshape(*shape, 3), -root[:, 2].reshape(shape))


def flat_to_root(points: torch.Tensor, root: torch.Tensor) -> torch.Tensor:
    """Express world points on the floor (N, ..., 2) in the frames of roots (N, 3)."""
    shape = (-1,) + (1,) * (points.dim() - 2)
    return turn(points - root[:, :2].reshape(*shape, 2), -root[:, 2].reshape(shape))


def on_floor(root: torch.Tensor) -> torch.Tensor:
    """Return the places (N, 3) of roots (N, 3) on the floor."""
    return torch.stack([root[:, 0], torch.zeros_like(root[:, 0]), root[:, 1]], -1)


def direction(yaw: torch.Tensor) -> torch.Tensor:
    """Return horizontal unit vectors (..., 2) of yaws (...)."""
    return torch.stack([torch.sin(yaw), torch.cos(yaw)], dim=-1)


def reroot(state: torch.Tensor) -> torch.Tensor:
    """Convert predicted states (B, 647) from the previous root frame to the frames of their own roots.

    Only pose and trajectory are converted; FUTURE, GOAL_TRAJECTORY and GOAL have to be filled in by the caller.
    """
    pose = state[:, POSE].reshape(-1, JOINTS, 4, 3)
    trajectory = state[:, TRAJECTORY].reshape(-1, SAMPLES, 9)
    origin = trajectory[:, NOW, 0:2]
    yaw = torch.atan2(trajectory[:, NOW, 2], trajectory[:, NOW, 3])
    offset = torch.stack([origin[:, 0], torch.zeros_like(yaw), origin[:, 1]], -1)
    pose = torch.cat([pose[:, :, :1] - offset[:, None, None, :], pose[:, :, 1:]], 2)
    pose = turn3(pose, -yaw[:, None, None].expand(pose.shape[:3]))
    spread = -yaw[:, None].expand(-1, SAMPLES)
    positions = turn(trajectory[..., 0:2] - origin[:, None], spread)
    directions = turn(trajectory[..., 2:4], spread)
    out = state.clone()
    out[:, POSE] = pose.reshape(len(state), -1)
    out[:, TRAJECTORY] = torch.cat([positions, directions, trajectory[..., 4:]], -1).reshape(len(state), -1)
    return out


def consistent(state: torch.Tensor) -> torch.Tensor:
    """Recompute FUTURE and GOAL_TRAJECTORY of states (B, 647) from their pose, trajectory and goal.

    As in a rollout, the state then contains no information about the future beyond the trajectory.
    """
    joints = state[:, POSE].reshape(-1, JOINTS, 4, 3)[:, :, 0]
    trajectory = state[:, TRAJECTORY].reshape(-1, SAMPLES, 9)
    yaw = torch.atan2(trajectory[..., 2], trajectory[..., 3])
    ahead = torch.cat([trajectory[:, -1, :2], yaw[:, -1:]], -1)
    goal = state[:, GOAL].reshape(-1, SAMPLES, 11)[:, NOW]
    frame = torch.stack([goal[:, 0], goal[:, 2], torch.atan2(goal[:, 3], goal[:, 5])], -1)
    relative = torch.cat([flat_to_root(trajectory[..., :2], frame), direction(yaw - frame[:, 2:])], -1)
    out = state.clone()
    out[:, FUTURE] = to_root(joints, ahead).reshape(len(state), -1)
    out[:, GOAL_TRAJECTORY] = relative.reshape(len(state), -1)
    return out


def extrapolate(state: torch.Tensor) -> torch.Tensor:
    """Extrapolate states (B, 647) by one frame, in the same root frames.

    Joints continue at their velocities and the trajectory window moves by one frame; contacts are set to zero.
    """
    out = state.clone()
    pose = out[:, POSE].view(-1, JOINTS, 4, 3)
    pose[:, :, 0] += pose[:, :, 3] / FPS
    for part, numbers in ((TRAJECTORY, 9), (GOAL_TRAJECTORY, 4)):
        window = out[:, part].view(-1, SAMPLES, numbers)
        step = (window[:, 1:] - window[:, :-1]) / SAMPLE_STRIDE
        window += torch.cat([step, step[:, -1:]], 1)
    out[:, CONTACTS].zero_()
    return out


def assemble(
    reference: torch.Tensor,
    joints: torch.Tensor,
    axes: torch.Tensor,
    velocities: torch.Tensor,
    future_root: torch.Tensor,
    window_roots: torch.Tensor,
    window_actions: torch.Tensor,
    contacts: torch.Tensor,
    goal: torch.Tensor,
    window_goals: torch.Tensor,
) -> torch.Tensor:
    """Assemble states (N, 647) of N frames.

    reference: (N, 3) roots in whose frames the states are expressed. joints: (N, 22, 3) world positions. axes:
    (N, 22, 2, 3) world forward and up columns. velocities: (N, 22, 3) m/s. future_root: (N, 3) one second ahead.
    window_roots: (N, 13, 3). window_actions: (N, 13, 5). contacts: (N, 5). goal: (N, 6) the current goal's world
    position and direction. window_goals: (N, 13, 11) world position, direction, action.
    """
    n, yaw, origin = len(reference), reference[:, 2:], on_floor(reference)[:, None]
    # All vectors of one frame are turned in one call: the number of calls takes most of a rollout's time.
    pose = torch.cat([(joints - origin)[:, :, None], axes, velocities[:, :, None]], 2).reshape(n, -1, 3)
    vectors = torch.cat([pose, window_goals[..., :3] - origin, window_goals[..., 3:6]], 1)
    pose, places, facings = turn3(vectors, -yaw).split([pose.shape[1], SAMPLES, SAMPLES], 1)
    goals = torch.cat([places, facings, window_goals[..., 6:]], -1)
    future = to_root(joints, future_root)
    facing = direction(window_roots[..., 2])
    goal_frame = torch.stack([goal[:, 0], goal[:, 2], torch.atan2(goal[:, 3], goal[:, 5])], -1)
    trajectory, goal_trajectory = (
        torch.cat(
            turn(torch.cat([window_roots[..., :2] - frame[:, None, :2], facing], 1), -frame[:, 2:]).split(
                SAMPLES, 1
            ),
            -1,
        )
        for frame in (reference, goal_frame)
    )
    trajectory = torch.cat([trajectory, window_actions], -1)
    parts = [part.reshape(n, -1) for part in (pose, future, trajectory, contacts, goal_trajectory, goals)]
    return torch.cat(parts, -1)


def interaction_features(
    centres: torch.Tensor, occupancy: torch.Tensor, root: torch.Tensor, reach: float = 3.0
) -> torch.Tensor:
    """Return the object's features (N, 2048) in the frames of roots (N, 3).

    centres: (N, 512, 3) world cell centres. occupancy: (N, 512). The features fade to zero with the distance of the
    object's centre, from ``reach`` minus 0.5 m to ``reach`` metres.
    """
    local = to_root(centres, root)
    # Contiguous, because the norm of a strided row is rounded differently.
    distance = local.mean(1)[:, 0::2].contiguous().norm(dim=-1)
    weight = ((reach - distance) / 0.5).clamp(0.0, 1.0)
    return (torch.cat([local, occupancy[..., None]], -1) * weight[:, None, None]).reshape(len(root), -1)
