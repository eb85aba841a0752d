"""The preview picture of an asset: a body in one pose, traced by rays, so that it needs no window and no GPU."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...body import human
from ...body.human import Human
from ...motion import Motion
from ..render.camera_picture import Tracer

SIZE = 128
"""Pixels along an edge."""
MARGIN = 1.12
AMBIENT = 0.35
"""Share of the light in shadow."""
TURN, TILT = np.radians(35.0), np.radians(12.0)
"""The camera stands to the left of the body's front and looks down a little."""
LIGHT = np.array([0.4, 0.75, 0.55])
BACKGROUND = 0.0
"""Alpha where there is no body."""


def of_body(body: Human, motion: Motion, frame: int, colours: Sequence[Sequence[float]]) -> np.ndarray:
    """Return the picture (SIZE, SIZE, 4) of a frame of a motion, its lowest row first, sRGB from 0 to 1.

    colours: linear (r, g, b) of each of human.MATERIALS.
    """
    pose = motion.pose_slice(slice(frame, frame + 1))
    points = human.skin(body, pose)[0].astype(np.float64)
    quads = body.faces[:, 2] != body.faces[:, 3]
    triangles = points[np.concatenate([body.faces[:, :3], body.faces[quads][:, [0, 2, 3]]])]
    parts = np.concatenate([body.materials, body.materials[quads]])
    side, up, back = _axes(pose.headings()[0])
    low, high = (np.array([limit(points @ axis) for axis in (side, up)]) for limit in (np.min, np.max))
    reach = MARGIN * float((high - low).max()) / 2
    steps = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    across, along = np.meshgrid(steps * reach, steps * reach)
    middle = (low + high) / 2
    nearest = float((points @ back).max()) + 1.0
    origins = (
        (middle[0] + across.ravel())[:, None] * side
        + (middle[1] + along.ravel())[:, None] * up
        + nearest * back
    )
    hits = Tracer(triangles).trace(origins, np.broadcast_to(-back, origins.shape))
    light = AMBIENT + (1 - AMBIENT) * np.clip(hits.normal @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)
    linear = np.asarray(colours, float)[parts[hits.face]] * light[:, None] * 1.6
    picture = np.concatenate([np.clip(linear, 0, 1) ** (1 / 2.2), np.ones((len(origins), 1))], axis=1)
    picture[hits.face < 0] = BACKGROUND
    return picture.reshape(SIZE, SIZE, 4)


def _axes(heading: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the picture's right, its up, and the direction to the camera (3,), from the body's heading (3,)."""
    up = np.array([0.0, 1.0, 0.0])
    left = np.cross(up, heading)
    front = np.cos(TURN) * heading + np.sin(TURN) * left
    back = np.cos(TILT) * front + np.sin(TILT) * up
    side = np.cross(up, front)
    return side, np.cross(back, side), back
