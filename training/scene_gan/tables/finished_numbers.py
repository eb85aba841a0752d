"""The measures of one finished take in its room and before its camera's depth map."""

from __future__ import annotations

import numpy as np
import torch

from ....samp_addon.evaluation import collision, feet, metrics
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.methods.scene_gan import liveliness, placing
from ....samp_addon.methods.scene_gan.ground import Ground
from ....samp_addon.methods.scene_gan.improvisation import OVERLAP, USED
from ....samp_addon.methods.take import Take
from ....samp_addon.motion import Motion
from ....samp_addon.scene.camera_view import CameraView
from ....samp_addon.skeleton import BODY_COUNT, INDEX
from . import measures

STRIDE = USED - OVERLAP  # frames between two joins
EVERY = 5  # frames between two that are compared with the room
ON_FLOOR = 0.03  # height over the floor up to which a point belongs to it, metres
WALKING = 0.4  # speed of the pelvis, m/s, over half a second, from which on a body walks
GAIT = 14  # frames before and after one over which the distance of the ankles varies: about a stride
GLIDING = 0.05  # metres of standard deviation of that distance below which a walking body makes no steps
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
        "length_m": float(np.linalg.norm(np.diff(motion.root[::EVERY], axis=0)[:, [0, 2]], axis=-1).sum()),
        "seen_share": float(placing.seen_from(view, motion.root, floor).mean()),
        "remarks": len(take.remarks),
        "on_navmesh": float(ground.fits(motion.root, floor).mean() >= 1 - TOLERATED),
        "stooping_share": float((liveliness.stooping(motion.forward_kinematics()[0]) > 0).mean()),
        "seated_share": float((~ground.upright(motion.root)).mean()),
        "deeper_than_2cm": float((deepest > 0.02).mean()), "deeper_than_5cm": float((deepest > 0.05).mean()),
        "points_inside": points_inside(compared, view, floor),
        **gait(motion), **feet.measures(motion, take.floor),
    }  # fmt: skip


def gait(motion: Motion) -> dict[str, float | None]:
    """Return the share of frames in which the pelvis travels; and of these frames, how much the distance of the ankles
    varies, cm, and the share without steps, None where there is none; 12 cm and 0.14 in captured motion."""
    joints = motion.forward_kinematics()[0]
    half = round(motion.fps / 4)
    root = motion.root[:, [0, 2]]
    speed = np.zeros(len(motion))
    speed[half:-half] = (
        np.linalg.norm(root[2 * half :] - root[: -2 * half], axis=-1) * motion.fps / (2 * half)
    )
    apart = np.linalg.norm(joints[:, INDEX["left_ankle"]] - joints[:, INDEX["right_ankle"]], axis=-1)
    walking = np.flatnonzero(speed > WALKING)
    swing = np.array([apart[max(k - GAIT, 0) : k + GAIT + 1].std() for k in walking])
    return {
        "walking_share": len(walking) / len(motion),
        "ankle_swing_cm": 100 * float(swing.mean()) if len(swing) else None,
        "gliding_share_of_walking": float((swing < GLIDING).mean()) if len(swing) else None,
    }


def points_inside(motion: Motion, view: CameraView, floor: float) -> dict[str, list[float]]:
    """Return, for each radius, the number of points of the depth map inside the body in each frame.

    They are counted as by measures.collisions for the raw network, and once more without those of the floor: cylinders
    of 60 mm around the bones of feet that stand on it contain some.
    """
    joints, _ = motion.forward_kinematics()
    turn, moved = view.extrinsics[:3, :3], view.extrinsics[:3, 3]
    seen = _tensor(joints[:, :BODY_COUNT] @ turn.T + moved)
    points = measures.cloud(_tensor(view.depth), _tensor(view.lens))
    above = (points - _tensor(moved)) @ _tensor(turn[:, 1]) > floor + ON_FLOOR
    each = (measures.COUNTED_WIDTH / view.depth.shape[1]) ** 2
    return {
        f"{1000 * radius:.0f} mm{name}": (each * measures.points_inside(seen, some, radius)).tolist()
        for radius in measures.RADII
        for name, some in (("", points), (" off the floor", points[above]))
    }


def _tensor(values: np.ndarray) -> torch.Tensor:
    return torch.as_tensor(values, dtype=torch.float32)


def jerk_at_joins(motion: Motion) -> float:
    """Return the 99th percentile of the joints' jerk in the frames around the joins of windows, m/s^3."""
    joins = np.arange(STRIDE, len(motion) - 4, STRIDE)
    rows = np.unique((joins[:, None] + np.arange(-2, OVERLAP + 3)).ravel())
    joints = motion.forward_kinematics()[0][:, :BODY_COUNT]
    found = np.linalg.norm(np.diff(joints, n=3, axis=0), axis=-1) * motion.fps**3
    rows = rows[rows < len(found)]
    return float(np.percentile(found[rows], 99)) if len(rows) else 0.0
