"""Draws where a body would be while an artist aims at a place: the body, the furniture and the facing, green or red.

Nothing is added to the scene. The meshes are uploaded once for each pose and piece, then only moved.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ... import frames
from ...body import figures, human
from ...body.human import Human
from ...pipeline.placing import Spot

FITS, NOT = (0.25, 0.85, 0.35), (0.95, 0.25, 0.2)
"""Colours of places where a body fits and where it does not."""

BODY_ALPHA, PIECE_ALPHA = 0.85, 0.22
LIGHT = np.array([0.35, -0.55, 0.76])
AMBIENT = 0.4
"""Share of the colour in shadow."""

STEP = 0.05
"""Metres of the height of a seat between two poses."""

RING = 0.28
"""Radius in metres of the ring below the body."""

LIFT = 0.012
"""Metres by which ring and furniture are drawn over the surfaces, against z-fighting."""

STANDING = "stand"

_alive: list[PlaceFigure] = []


def shown() -> Spot | None:
    """Return the spot that is drawn now, or None."""
    return _alive[-1].spot if _alive else None


class PlaceFigure:
    """Draws a spot in all 3D views from its creation until `remove`."""

    def __init__(self, body: Human | None = None) -> None:
        self.body = body or human.load()
        faces = self.body.faces
        quads = faces[:, 2] != faces[:, 3]
        self._triangles = np.concatenate([faces[:, :3], faces[quads][:, [0, 2, 3]]]).astype(np.int32)
        self.spot: Spot | None = None
        self._floor = 0.0
        self._piece: np.ndarray | None = None
        self._stroke: np.ndarray | None = None
        self._bodies: dict[tuple, object] = {}
        self._pieces: dict[tuple, object] = {}
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")
        _alive.append(self)

    def show(self, spot: Spot | None, piece: np.ndarray | None = None, floor: float = 0.0) -> None:
        """Set what is drawn. piece: (F, 3, 3) of the furniture. floor: height under it. Network frame."""
        self.spot, self._piece, self._floor = spot, piece, floor

    def stroke(self, points: np.ndarray | None) -> None:
        """Set the line (N, 3) that is drawn on the floor, Blender's world; None for none."""
        self._stroke = points

    @staticmethod
    def redraw(context: bpy.types.Context) -> None:
        """Redraw the window's 3D views."""
        for area in context.window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()

    def remove(self) -> None:
        """Stop drawing."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            self._handle = None
            _alive.remove(self)

    def pose(self, spot: Spot) -> tuple[str, float, str]:
        """Return which pose shows a spot: action, height of a seated pelvis over the floor, posture."""
        if spot.action == "walk":
            return STANDING, 0.0, ""
        over = float(spot.goal.position[1]) - self._floor
        return spot.action, round(over / STEP) * STEP if spot.action == "sit" else 0.0, spot.posture

    def skin(self, action: str, over_floor: float, posture: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Return the vertices (V, 3) of a pose, its pelvis at the origin, in Blender's axes, and their light (V,)."""
        points = human.skin(self.body, figures.figure(action, over_floor, posture))[0]
        points = frames.to_blender(points).astype(np.float32)
        corners = points[self._triangles]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.zeros_like(points)
        for corner in range(3):
            np.add.at(normals, self._triangles[:, corner], faces)
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
        return points, (AMBIENT + (1 - AMBIENT) * np.clip(normals @ LIGHT, 0, 1)).astype(np.float32)

    def matrix(self, spot: Spot) -> Matrix:
        """Return the matrix that moves a pose to a spot."""
        place = np.asarray(spot.goal.position, float)
        if spot.action == "walk":
            place = place - [0.0, self.body.floor, 0.0]
        yaw = spot.yaw if np.any(spot.goal.direction) else 0.0
        turn = Matrix.Rotation(yaw, 4, "Z")
        return Matrix.Translation(frames.to_blender(place).tolist()) @ turn

    def _draw(self) -> None:
        import gpu

        if self._stroke is not None and len(self._stroke) > 1:
            self._lines([*self._stroke], FITS, "LINE_STRIP")
        spot = self.spot
        if spot is None:
            return
        colour = FITS if spot.fits else NOT
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.blend_set("ALPHA")
        try:
            if self._piece is not None:
                self._furniture(colour)
            gpu.state.depth_mask_set(True)
            key = (*self.pose(spot), spot.fits)
            shader = gpu.shader.from_builtin("SMOOTH_COLOR")
            batch = self._bodies.get(key) or self._bodies.setdefault(key, self._batch(shader, *key))
            with gpu.matrix.push_pop():
                gpu.matrix.multiply_matrix(self.matrix(spot))
                batch.draw(shader)
            gpu.state.depth_mask_set(False)
            self._ring(spot, colour)
        finally:
            gpu.state.blend_set("NONE")
            gpu.state.depth_mask_set(False)
            gpu.state.depth_test_set("NONE")

    def _batch(self, shader: object, action: str, over_floor: float, posture: str, fits: bool) -> object:
        from gpu_extras.batch import batch_for_shader

        points, light = self.skin(action, over_floor, posture)
        colours = np.concatenate(
            [light[:, None] * np.array(FITS if fits else NOT), np.full((len(points), 1), BODY_ALPHA)], -1
        ).astype(np.float32)
        return batch_for_shader(shader, "TRIS", {"pos": points, "color": colours}, indices=self._triangles)

    def _furniture(self, colour: tuple[float, float, float]) -> None:
        import gpu
        from gpu_extras.batch import batch_for_shader

        shader = gpu.shader.from_builtin("UNIFORM_COLOR")
        key = id(self._piece), len(self._piece)
        if key not in self._pieces:
            points = frames.to_blender(self._piece).reshape(-1, 3)
            # Slightly larger than the furniture, so that it is drawn over it.
            middle = (points.min(0) + points.max(0)) / 2
            size = np.maximum(points.max(0) - points.min(0), 0.1)
            points = (middle + (points - middle) * (1 + 2 * LIFT / size)).astype(np.float32)
            self._pieces = {key: batch_for_shader(shader, "TRIS", {"pos": points})}
        shader.uniform_float("color", (*colour, PIECE_ALPHA))
        self._pieces[key].draw(shader)

    def _ring(self, spot: Spot, colour: tuple[float, float, float]) -> None:
        """Draw the ring on the surface, and the arrow of the facing."""
        centre = frames.to_blender(spot.point) + [0.0, 0.0, LIFT]
        angles = np.linspace(0, 2 * np.pi, 33)
        ring = centre + RING * np.stack([np.cos(angles), np.sin(angles), np.zeros(33)], -1)
        self._lines([*ring], colour, "LINE_STRIP")
        if np.any(spot.goal.direction):
            ahead = frames.to_blender(spot.goal.direction)
            side = np.array([-ahead[1], ahead[0], 0.0])
            tip = centre + 0.6 * ahead
            lines = [centre + RING * ahead, tip, tip, tip - 0.12 * ahead + 0.08 * side]
            self._lines([*lines, tip, tip - 0.12 * ahead - 0.08 * side], colour, "LINES")

    @staticmethod
    def _lines(points: list[np.ndarray], colour: tuple[float, float, float], kind: str) -> None:
        import gpu
        from gpu_extras.batch import batch_for_shader

        shader = gpu.shader.from_builtin("UNIFORM_COLOR")
        gpu.state.line_width_set(3.0)
        shader.uniform_float("color", (*colour, 1.0))
        batch_for_shader(shader, kind, {"pos": np.array(points, dtype=np.float32)}).draw(shader)
        gpu.state.line_width_set(1.0)
