"""Previews the character in the 3D views while a take is generated; nothing is added to the scene."""

from __future__ import annotations

import time

import bpy
import numpy as np

from ... import frames
from ...body import human
from ...body.human import Human
from ...motion import Motion

COLOUR = np.array([0.35, 0.62, 1.0])
LIGHT = np.array([0.35, -0.55, 0.76])
AMBIENT = 0.35  # share of the colour in shadow
PAUSE = 1.5  # seconds on the last frame before a finished take repeats


class Ghost:
    """Draws a body in all 3D views from its creation until ``remove``."""

    def __init__(self, body: Human | None = None) -> None:
        self.body = body or human.load()
        faces = self.body.faces
        quads = faces[:, 2] != faces[:, 3]
        self._triangles = np.concatenate([faces[:, :3], faces[quads][:, [0, 2, 3]]]).astype(np.int32)
        self._motion: Motion | None = None
        self._start, self._drawn, self._batch = 0.0, None, None
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")

    def show(self, motion: Motion | None) -> None:
        """Set the motion to draw: a single frame, or a take that is played in a loop. Network frame."""
        if motion is not self._motion:
            self._motion, self._start = motion, time.monotonic()

    def remove(self) -> None:
        """Stop drawing."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            self._handle = None

    def frame(self, now: float | None = None) -> int:
        """Return the frame of the motion to draw at a time of time.monotonic, by default now."""
        elapsed = (time.monotonic() if now is None else now) - self._start
        period = self._motion.seconds + PAUSE
        return min(int((elapsed % period) * self._motion.fps), len(self._motion) - 1)

    def skin(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the body's vertices (V, 3) in a frame, in Blender's world, and their colours (V, 4)."""
        pose = self._motion.pose_slice(slice(frame, frame + 1))
        points = frames.to_blender(human.skin(self.body, pose)[0]).astype(np.float32)
        corners = points[self._triangles]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.stack(
            [np.bincount(self._triangles.ravel(), np.repeat(faces[:, k], 3), len(points)) for k in range(3)],
            -1,
        )
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
        light = AMBIENT + (1 - AMBIENT) * np.clip(normals @ LIGHT, 0, 1)
        colours = np.concatenate([light[:, None] * COLOUR, np.ones((len(points), 1))], -1)
        return points, colours.astype(np.float32)

    def _draw(self) -> None:
        if self._motion is None:
            return
        import gpu
        from gpu_extras.batch import batch_for_shader

        frame = self.frame()
        shader = gpu.shader.from_builtin("SMOOTH_COLOR")
        if self._drawn != (id(self._motion), frame):
            points, colours = self.skin(frame)
            self._batch = batch_for_shader(
                shader, "TRIS", {"pos": points, "color": colours}, indices=self._triangles
            )
            self._drawn = id(self._motion), frame
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(True)
        self._batch.draw(shader)
        gpu.state.depth_mask_set(False)
        gpu.state.depth_test_set("NONE")
