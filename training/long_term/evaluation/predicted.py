"""Predicted windows in the frame of their start, and their errors against captured ones (paper, section 4.3)."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from ....models.long_term import layout
from ....models.long_term.pose_prior import PosePrior
from ..data import LongTermData, Windows

MEASURES = ("translation", "orientation", "pose", "MPJPE", "MPVPE", "v2v", "v2v_speed")
MILLIMETRES, HUNDRED = 1000.0, 100.0


@dataclass(frozen=True)
class Predicted:
    """Predicted windows.

    route: (B, T, 9), t and r. turns: (B, T, 21, 3, 3) local rotations. Both ends are included; where a method does not
    reproduce them, the given ends are added to its own frames, see `with_ends`.
    """

    route: torch.Tensor
    turns: torch.Tensor


def truth(windows: Windows) -> Predicted:
    """Return captured windows."""
    return Predicted(windows.route, windows.turns)


def with_ends(windows: Windows, route: torch.Tensor, turns: torch.Tensor) -> Predicted:
    """Return the frames between (B, T - 2, ...) with the given ends."""
    ends = lambda known, made: torch.cat([known[:, :1], made, known[:, -1:]], 1)
    return Predicted(ends(windows.route, route), ends(windows.turns, turns))


def figures(data: LongTermData, made: Predicted, betas: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return joints (B, T, 22, 3) and skin (B, T, V, 3)."""
    count, frames = made.route.shape[:2]
    model = data.model
    shape = betas.repeat_interleave(frames, 0)
    rest = model.rest_joints(shape)
    pelvis = layout.matrix_from_six(made.route[..., 3:]).flatten(0, 1)[:, None]
    joints, turned = model.joints(
        made.route[..., :3].flatten(0, 1), torch.cat([pelvis, made.turns.flatten(0, 1)], 1), rest
    )
    skin = model.skin(joints, turned, rest, shape)
    return joints.unflatten(0, (count, frames)), skin.unflatten(0, (count, frames))


@torch.no_grad()
def errors(
    data: LongTermData, prior: PosePrior, windows: Windows, made: Predicted
) -> dict[str, torch.Tensor]:
    """Return the measures (B,) of each window against the captured one.

    L1 distances of t, r and p times 100, mean over numbers; MPJPE and MPVPE in millimetres; all over the frames between
    the ends. v2v: mean distance of the skin between each given end and the adjacent frame, centimetres. v2v_speed: the
    jump of the skin's velocity at both ends, metres per second; the frames before and after the window are unknown, so
    the reference is the captured window's first and last step.
    """
    inner = slice(1, -1)
    true = truth(windows)
    code = lambda turns: prior.encode(turns[:, inner])[0]
    route = (made.route - true.route)[:, inner].abs()
    pose = (code(made.turns) - code(true.turns)).abs()
    joints, skin = figures(data, made, windows.betas)
    known, surface = figures(data, true, windows.betas)
    step = lambda s: torch.stack([s[:, 1] - s[:, 0], s[:, -1] - s[:, -2]], 1)
    jumps = torch.stack([skin[:, 1] - surface[:, 0], surface[:, -1] - skin[:, -2]], 1)
    return {
        "translation": HUNDRED * route[..., :3].mean((1, 2)),
        "orientation": HUNDRED * route[..., 3:].mean((1, 2)),
        "pose": HUNDRED * pose.mean((1, 2)),
        "MPJPE": MILLIMETRES * (joints - known)[:, inner].norm(dim=-1).mean((1, 2)),
        "MPVPE": MILLIMETRES * (skin - surface)[:, inner].norm(dim=-1).mean((1, 2)),
        "v2v": HUNDRED * jumps.norm(dim=-1).mean((1, 2)),
        "v2v_speed": 30 * (jumps - step(surface)).norm(dim=-1).mean((1, 2)),
    }
