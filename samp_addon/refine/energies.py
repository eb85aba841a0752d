"""The energies that refining makes small (Long-term motion, section 3.4), each differentiable through the skin.

All are means over frames, so that a take's length does not matter. Network frame, metres, radians.
"""

from __future__ import annotations

import torch

from ..skeleton import INDEX

LEFT, RIGHT = ([INDEX[f"{side}_{name}"] for name in ("hip", "shoulder")] for side in ("left", "right"))
TURN = 0.8
"""Metres beside the goal that weigh as much as a radian beside its direction."""

SHIFT = 10.0
"""Squared radians of a joint that weigh as much as a squared metre of the whole body."""

CONTACT_SCALE = 0.03
"""Metres at which half of Geman-McClure's error is reached: farther surfaces pull less and less."""


def foot_location(feet: torch.Tensor, places: torch.Tensor, standing: torch.Tensor) -> torch.Tensor:
    """E_foot: distance of standing feet from where they stand on average in their stance.

    feet, places: (T, F, 3) metres, ankles and balls of both. standing: (T, F) from 0 to 1.
    """
    return (((feet - places).square().sum(-1) + 1e-8).sqrt() * standing).sum() / len(feet)


def collision(distance: torch.Tensor, margin: torch.Tensor | float, frames: int) -> torch.Tensor:
    """E_col, equation 5: how far vertices (N,) with these signed distances, metres, are in the scene.

    margin: metres that they are to keep off, (N,) or one number. frames: from which the vertices are.
    """
    return torch.relu(margin - distance).sum() / frames


def contact(distance: torch.Tensor, near: float, frames: int) -> torch.Tensor:
    """E_cont, equation 6: Geman-McClure's error of contact vertices (N,) that are farther off than near, metres."""
    square = torch.relu(distance - near).square()
    return (square / (square + CONTACT_SCALE**2)).sum() / frames


def held(distance: torch.Tensor, near: float, frames: int) -> torch.Tensor:
    """E_cont's other half: metres by which the nearest vertices (N,), one of each frame, are farther off than near.

    Geman-McClure's error lets go of what is far; of a body that is carried, some part touches.
    """
    return torch.relu(distance - near).sum() / frames


def smoothness(displacement: torch.Tensor) -> torch.Tensor:
    """E_smooth, equation 7, of how vertices or joints (T, V, 3) are displaced from the take that is refined.

    Of the places themselves it would draw every motion to a stop; of what is changed it keeps what was alive.
    """
    steps = displacement[1:] - displacement[:-1]
    return (steps.square().sum(-1) + 1e-10).sqrt().sum() / max(len(displacement), 1)


def closeness(shift: torch.Tensor, turn: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
    """Of staying with the take that is refined. shift: (T, 3) metres, turn: (T, 22, 3), weights: (22,)."""
    return SHIFT * shift.square().sum(-1).mean() + (turn.square().sum(-1) * weights).sum(-1).mean()


def on_ground(feet: torch.Tensor, places: torch.Tensor, standing: torch.Tensor) -> torch.Tensor:
    """Heights, metres, by which standing feet leave the ground: the first stage lets them slide, not fly.

    feet, places: (T, F, 3). standing: (T, F) from 0 to 1.
    """
    return ((feet - places)[..., 1].abs() * standing).sum() / len(feet)


def joint_limits(local: torch.Tensor, limits: torch.Tensor) -> torch.Tensor:
    """Of joints turned past their limits (22,), radians. local: rotation matrices (T, 22, 3, 3)."""
    cosine = (local.diagonal(dim1=-2, dim2=-1).sum(-1) - 1) / 2
    # Compared as cosines: their slope does not vanish where the angle's is unbounded.
    return torch.relu(torch.cos(limits) - cosine).square().sum(-1).mean()


def on_goal(
    joints: torch.Tensor, goal: torch.Tensor, direction: torch.Tensor, resting: torch.Tensor
) -> torch.Tensor:
    """Squared distance, metres, of the pelvis from its goal (3,), and squared sine of the angle to its direction (3,),
    a radian as much as TURN metres, in the frames that rest there (T,), 0 or 1. joints: (T, 22, 3)."""
    across = joints[:, LEFT].sum(1) - joints[:, RIGHT].sum(1)
    facing = torch.stack([-across[:, 2], torch.zeros_like(across[:, 0]), across[:, 0]], -1)
    off = 1 - (facing / facing.norm(dim=-1, keepdim=True).clamp(min=1e-6) * direction).sum(-1)
    error = (joints[:, 0] - goal).square().sum(-1) + 2 * TURN**2 * off
    return (error * resting).sum() / resting.sum().clamp(min=1)
