"""The measures of one finished take in its room and before its camera's depth map."""

from __future__ import annotations

import numpy as np
import torch

from ....samp_addon.evaluation import collision, feet, metrics
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.methods.scene_gan.ground import Ground
from ....samp_addon.methods.scene_gan.improvisation import OVERLAP, WINDOW
from ....samp_addon.methods.take import Take
from ....samp_addon.motion import Motion
from ....samp_addon.scene.camera_view import CameraView
from ....samp_addon.skeleton import BODY_COUNT
from . import measures

STRIDE = WINDOW - OVERLAP  # frames between two joins
EVERY = 5  # frames between two that are compared with the room
TOLERATED = 0.02  # share of frames beside the navmesh of a take that counts as on it


def of_take(take: Take, view: CameraView, ground: Ground, obstacles: Obstacles) -> dict:
    """Return the measures of one take; lists have a number for each compared frame."""
    motion = take.motion
    floor = float(ground.floor(motion.root[:1] - [0.0, ground.standing, 0.0])[0])
    compared = motion.pose_slice(slice(None, None, EVERY))
    inside, _ = collision.body_depth(compared, obstacles, floor)
    deepest = np.maximum(inside.max(1), collision.surface_depth(compared, obstacles, floor))
    return {
        "jerk_m_s3": metrics.jerk(motion), "jerk_at_joins_m_s3": jerk_at_joins(motion),
        "way_m": float(np.linalg.norm((motion.root[-1] - motion.root[0])[[0, 2]])),
        "remarks": len(take.remarks),
        "on_navmesh": float(ground.fits(motion.root, floor).mean() >= 1 - TOLERATED),
        "seated_share": float((~ground.upright(motion.root)).mean()),
        "deeper_than_2cm": float((deepest > 0.02).mean()), "deeper_than_5cm": float((deepest > 0.05).mean()),
        "points_inside": points_inside(compared, view),
        **feet.measures(motion, take.floor),
    }  # fmt: skip


def points_inside(motion: Motion, view: CameraView) -> dict[str, list[float]]:
    """Return, for each radius, the number of points of the depth map inside the body in each frame.

    They are counted as by measures.collisions for the raw network.
    """
    joints, _ = motion.forward_kinematics()
    seen = joints[:, :BODY_COUNT] @ view.extrinsics[:3, :3].T + view.extrinsics[:3, 3]
    tensor = lambda values: torch.as_tensor(values, dtype=torch.float32)
    points = measures.cloud(tensor(view.depth), tensor(view.lens))
    each = (measures.COUNTED_WIDTH / view.depth.shape[1]) ** 2
    return {
        f"{1000 * radius:.0f} mm": (each * measures.points_inside(tensor(seen), points, radius)).tolist()
        for radius in measures.RADII
    }


def jerk_at_joins(motion: Motion) -> float:
    """Return the 99th percentile of the joints' jerk in the frames around the joins of windows, m/s^3."""
    joins = np.arange(WINDOW - OVERLAP, len(motion) - 4, STRIDE)
    rows = np.unique((joins[:, None] + np.arange(-2, OVERLAP + 3)).ravel())
    joints = motion.forward_kinematics()[0][:, :BODY_COUNT]
    found = np.linalg.norm(np.diff(joints, n=3, axis=0), axis=-1) * motion.fps**3
    rows = rows[rows < len(found)]
    return float(np.percentile(found[rows], 99)) if len(rows) else 0.0
