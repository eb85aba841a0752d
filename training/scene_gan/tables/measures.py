"""Motion FID, non-collision and behaviour of windows in their rooms (section 4.3)."""

from __future__ import annotations

import numpy as np
import torch

from ....models.scene_gan import kinematics
from ....models.scene_gan.projection import Motions
from ....models.scene_gan.start import Start
from ....samp_addon.evaluation.diversity import frechet_distance
from . import erd

CLIPS = {"short": (2, 4), "mid": (8, 16), "long": (32, 64)}
"""Frames of the clips whose FIDs are averaged."""
RADII = (0.03, 0.045, 0.06)  # metres
THRESHOLDS = (40, 60, 80, 100)  # largest numbers of points of the depth map inside the body
COUNTED_WIDTH = 256  # width (pixels) to which the counts of other maps are scaled
SITTING, MOVING = 0.65, 0.5
"""Height of the pelvis, relative to standing, below which a body sits; least displacement (m) of a walk."""


@torch.no_grad()
def motion_fid(networks: dict[int, erd.Erd], real: torch.Tensor, made: torch.Tensor) -> dict[str, float]:
    """Return FIDs of generated frames (M, 64, NUMBERS) against captured ones (N, 64, NUMBERS): short, mid, long, mean.

    Each clip length is the mean over the networks; windows are cut into non-overlapping clips.
    """
    out = {}
    for name, lengths in CLIPS.items():
        found = []
        for length in lengths:
            cut = lambda x, n=length: x[:, : 64 // n * n].reshape(-1, n, x.shape[-1])
            for network in networks.values():
                features = [network.features(cut(x)).double().numpy() for x in (real, made)]
                found.append(frechet_distance(*features))
        out[name] = float(np.mean(found))
    out["mean"] = float(np.mean([out[name] for name in CLIPS]))
    return out


def cloud(depth: torch.Tensor, lens: torch.Tensor) -> torch.Tensor:
    """Return the points (H W, 3) of a depth map (H, W) in camera coordinates, metres; distant without depth."""
    height, width = depth.shape
    y, x = torch.meshgrid(torch.arange(height) + 0.5, torch.arange(width) + 0.5, indexing="ij")
    points = torch.stack(
        [(x / width - lens[1]) / lens[0] * depth, (y / width - lens[2]) / lens[0] * depth, depth], -1
    )
    return torch.where(depth[..., None] > 0, points, torch.full_like(points, 1e3)).reshape(-1, 3)


def points_inside(joints: torch.Tensor, points: torch.Tensor, radius: float) -> torch.Tensor:
    """Return the number (T,) of points (N, 3) within a radius of a bone of each body (T, 22, 3), metres."""
    parents = torch.tensor(kinematics.PARENTS[1:])
    begin, end = joints[:, parents], joints[:, 1:]
    near = ((points - joints.reshape(-1, 3).mean(0)).abs() < 3.0).all(-1)
    points = points[near]
    along = end - begin
    length = along.square().sum(-1).clamp(min=1e-9)
    counts = []
    for frame in range(len(joints)):
        away = points[:, None] - begin[frame]
        share = ((away * along[frame]).sum(-1) / length[frame]).clamp(0, 1)
        distance = (
            (away - share[..., None] * along[frame]).square().sum(-1).min(-1).values
            if len(points)
            else points[:, 0]
        )
        counts.append((distance < radius**2).sum())
    return torch.stack(counts)


def non_collision(counts: torch.Tensor) -> float:
    """Return the share of frames (N,) that do not collide, mean over THRESHOLDS."""
    return float(np.mean([(counts <= limit).float().mean() for limit in THRESHOLDS]))


def collisions(
    motions: Motions, start: Start, depth: torch.Tensor, frames: torch.Tensor
) -> dict[float, torch.Tensor]:
    """Return, for each radius, the number (B,) of points inside the body in one frame of each window.

    depth: (B, H, W) metres of the whole picture, shifted like its start. frames: (B,) from 0 to 64.
    """
    from ....models.scene_gan.projection import to_camera

    rows = torch.arange(len(start))
    seen = to_camera(motions.joints[rows, frames], start.camera)
    clouds = [cloud(depth[k], start.lens[k]) for k in range(len(start))]
    each = (COUNTED_WIDTH / depth.shape[2]) ** 2
    return {
        radius: each
        * torch.cat([points_inside(seen[k : k + 1], clouds[k], radius) for k in range(len(start))])
        for radius in RADII
    }


def behaviour(motions: Motions, start: Start) -> dict[str, float]:
    """Return the shares of windows that sit down, walk and stay, and the mean displacement, metres."""
    height = motions.root[..., 1] - motions.root[:, :1, 1] + start.height[:, None]
    standing = (-start.rest[:, :, 1].min(1).values)[:, None]
    low = height < SITTING * standing
    far = (motions.root[:, -1] - motions.root[:, 0])[:, [0, 2]].norm(dim=-1)
    sits = ~low[:, 0] & low[:, -1]
    walks = far > MOVING
    return {
        "sits_down": float(sits.float().mean()), "walks": float(walks.float().mean()),
        "stays": float((~walks & ~sits).float().mean()), "way_m": float(far.mean()),
    }  # fmt: skip


def spread(ways: torch.Tensor) -> torch.Tensor:
    """Return the standard deviation over time (64,) of samples (S, 65, 3) with the same start, metres (figure 7).

    The paper's samples also have the same end; here each is rotated and scaled in the plane to the end of the first
    one, and those that do not move away are left out.
    """
    moved = (ways - ways[:, :1])[..., [0, 2]]
    ends = torch.complex(moved[:, -1, 0], moved[:, -1, 1])
    far = ends.abs() > 0.3
    if int(far.sum()) < 2:
        return torch.zeros(ways.shape[1])
    places = torch.complex(moved[far][..., 0], moved[far][..., 1])
    aligned = places * (ends[far][0] / ends[far])[:, None]
    return torch.sqrt(torch.view_as_real(aligned).var(dim=0).sum(-1))
