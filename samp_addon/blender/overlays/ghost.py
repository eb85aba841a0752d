"""The character as it is while a take is made: drawn into the 3D views, beside the artist's scene, not in it."""

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
SHADOW = 0.35  # share of the colour that is left where no light comes
TURN = 1.5  # seconds for which a finished take's last frame stays before it begins again


class Ghost:
    """Draws a body in all 3D views until it is removed. Make it, show it motions, remove it."""

    def __init__(self, body: Human | None = None) -> None:
        self.body = body or human.load()
        faces = self.body.faces
        quads = faces[:, 2] != faces[:, 3]
        self._triangles = np.concatenate([faces[:, :3], faces[quads][:, [0, 2, 3]]]).astype(np.int32)
        self._motion: Motion | None = None
        self._since, self._drawn, self._batch = 0.0, None, None
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")

    def show(self, motion: Motion | None) -> None:
        """What is to be seen: a frame, or a take that is played again and again. Network frame."""
        if motion is not self._motion:
            self._motion, self._since = motion, time.monotonic()

    def remove(self) -> None:
        """Takes the drawing away."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            self._handle = None

    def frame(self, now: float | None = None) -> int:
        """The frame of the motion that is shown at a time of time.monotonic."""
        passed = (time.monotonic() if now is None else now) - self._since
        turn = self._motion.seconds + TURN
        return min(int((passed % turn) * self._motion.fps), len(self._motion) - 1)

    def skin(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Places (V, 3) of the body's vertices in Blender's world in a frame, and their colours (V, 4)."""
        one = self._motion.pose_slice(slice(frame, frame + 1))
        places = frames.to_blender(human.skin(self.body, one)[0]).astype(np.float32)
        corners = places[self._triangles]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.stack(
            [np.bincount(self._triangles.ravel(), np.repeat(faces[:, k], 3), len(places)) for k in range(3)],
            -1,
        )
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
        light = SHADOW + (1 - SHADOW) * np.clip(normals @ LIGHT, 0, 1)
        colours = np.concatenate([light[:, None] * COLOUR, np.ones((len(places), 1))], -1)
        return places, colours.astype(np.float32)

    def _draw(self) -> None:
        if self._motion is None:
            return
        import gpu
        from gpu_extras.batch import batch_for_shader

        frame = self.frame()
        shader = gpu.shader.from_builtin("SMOOTH_COLOR")
        if self._drawn != (id(self._motion), frame):
            places, colours = self.skin(frame)
            self._batch = batch_for_shader(
                shader, "TRIS", {"pos": places, "color": colours}, indices=self._triangles
            )
            self._drawn = id(self._motion), frame
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(True)
        self._batch.draw(shader)
        gpu.state.depth_mask_set(False)
        gpu.state.depth_test_set("NONE")
