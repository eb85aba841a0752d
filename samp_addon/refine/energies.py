"""The energies that refinement minimises (Long-term motion, section 3.4), differentiable through the skin.

All are means over frames, so that the length of a take does not matter. Network frame, metres, radians.
"""

from __future__ import annotations

import torch

from ..skeleton import INDEX

LEFT, RIGHT = ([INDEX[f"{side}_{name}"] for name in ("hip", "shoulder")] for side in ("left", "right"))
TURN = 0.8
"""Metres off the goal that weigh as much as a radian off its direction."""

SHIFT = 10.0
"""Squared radians of a joint that weigh as much as a squared metre of the whole body."""

CONTACT_SCALE = 0.03
"""Metres at which the Geman-McClure error reaches one half: farther surfaces attract less and less."""


def foot_location(feet: torch.Tensor, places: torch.Tensor, standing: torch.Tensor) -> torch.Tensor:
    """E_foot: distance of standing feet from their planned places.

    feet, places: (T, F, 3) metres, ankles and balls of both feet. standing: (T, F) from 0 to 1.
    """
    return (((feet - places).square().sum(-1) + 1e-8).sqrt() * standing).sum() / len(feet)


def collision(distance: torch.Tensor, margin: torch.Tensor | float, frames: int) -> torch.Tensor:
    """E_col, equation 5: depth of vertices in the scene, summed over vertices.

    distance: (N,) signed distances. margin: metres to keep from surfaces, (N,) or one number. frames: number of
    frames that the vertices come from.
    """
    return torch.relu(margin - distance).sum() / frames


def pierced(depth: torch.Tensor, weight: torch.Tensor, frames: int) -> torch.Tensor:
    """Complement of E_col for thin things: depths (N,) of surface samples in the body, summed over samples.

    E_col looks at vertices in solids; a seat of one sheet passes between them. weight: (N,) of the samples' frames,
    which add up to ``frames`` over all of these.
    """
    return (torch.relu(depth) * weight).sum() / frames


def contact(distance: torch.Tensor, near: float, frames: int) -> torch.Tensor:
    """E_cont, equation 6: Geman-McClure error of contact vertices (N,) by which they are farther off than ``near``."""
    square = torch.relu(distance - near).square()
    return (square / (square + CONTACT_SCALE**2)).sum() / frames


def support(distance: torch.Tensor, near: float, frames: int) -> torch.Tensor:
    """Complement of E_cont: metres by which the nearest vertices (N,), one per frame, are farther off than ``near``.

    The Geman-McClure error ignores what is far; but some part of a supported body touches its support.
    """
    return torch.relu(distance - near).sum() / frames


def smoothness(displacement: torch.Tensor) -> torch.Tensor:
    """E_smooth, equation 7, of the displacement (T, V, 3) of vertices or joints from the input take.

    Of the positions themselves it would slow every motion down; of the changes, it keeps the input's liveliness.
    """
    steps = displacement[1:] - displacement[:-1]
    return (steps.square().sum(-1) + 1e-10).sqrt().sum() / max(len(displacement), 1)


def closeness(shift: torch.Tensor, turn: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
    """Closeness to the input take. shift: (T, 3) metres, turn: (T, 22, 3) rotation vectors, weights: (22,)."""
    return SHIFT * shift.square().sum(-1).mean() + (turn.square().sum(-1) * weights).sum(-1).mean()


def on_ground(feet: torch.Tensor, places: torch.Tensor, standing: torch.Tensor) -> torch.Tensor:
    """Heights by which standing feet leave the ground: the first stage lets them slide, but not lift off.

    feet, places: (T, F, 3). standing: (T, F) from 0 to 1.
    """
    return ((feet - places)[..., 1].abs() * standing).sum() / len(feet)


def joint_limits(local: torch.Tensor, limits: torch.Tensor) -> torch.Tensor:
    """Excess of joints beyond their limits (22,), radians. local: rotation matrices (T, 22, 3, 3)."""
    cosine = (local.diagonal(dim1=-2, dim2=-1).sum(-1) - 1) / 2
    # Cosines are compared, not angles: the slope of arccos is unbounded at 0.
    return torch.relu(torch.cos(limits) - cosine).square().sum(-1).mean()


def on_goal(
    joints: torch.Tensor, goal: torch.Tensor, direction: torch.Tensor, resting: torch.Tensor
) -> torch.Tensor:
    """Squared distance of the pelvis from its goal, and of its facing from the goal's direction.

    joints: (T, 22, 3). goal, direction: (3,). resting: (T,) 1 in the frames that rest on the goal, else 0. A radian
    weighs as much as TURN metres.
    """
    across = joints[:, LEFT].sum(1) - joints[:, RIGHT].sum(1)
    facing = torch.stack([-across[:, 2], torch.zeros_like(across[:, 0]), across[:, 0]], -1)
    off = 1 - (facing / facing.norm(dim=-1, keepdim=True).clamp(min=1e-6) * direction).sum(-1)
    error = (joints[:, 0] - goal).square().sum(-1) + 2 * TURN**2 * off
    return (error * resting).sum() / resting.sum().clamp(min=1)
