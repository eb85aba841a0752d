"""Trace rays in a room with a body, by Embree. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..classes import PERSON
from ..layout.room import PANE, Room

NUDGE = 2e-3  # offset (m) of a ray's start from its surface


@dataclass
class Hits:
    """Hits of N rays: distance (N,), metres, inf without a hit; normal (N, 3) towards the eye; class, paint (N,);
    point (N, 3), metres."""

    distance: np.ndarray
    normal: np.ndarray
    classes: np.ndarray
    paints: np.ndarray
    point: np.ndarray


class Body:
    """A posed body. vertices: (V, 3) metres. faces: (F, 3). paints: (F,) below 0, see paints.PEOPLE."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, paints: np.ndarray) -> None:
        self.scene = _scene(vertices[faces])
        self.paints = paints


class Tracer:
    """A room's triangles, indexed for ray tracing."""

    def __init__(self, room: Room, open_top: bool = False) -> None:
        """Index a room. open_top: leave out the ceiling, for views from above."""
        keep = np.ones(len(room.triangles), bool)
        if open_top:
            keep &= room.classes != 2
        self.classes, self.paints = room.classes[keep], room.paints[keep]
        self.scene = _scene(room.triangles[keep])
        panes = [k for k, name in enumerate(room.paint_names) if name == PANE]
        clear = np.isin(self.paints, panes)
        # Panes transmit light.
        self.solid = _scene(room.triangles[keep][~clear])

    def trace(self, origins: np.ndarray, directions: np.ndarray, body: Body | None = None) -> Hits:
        """Return the first hits of rays from origins (N, 3) along unit directions (N, 3)."""
        origins, directions = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
        found = self.scene.run(origins, directions, output=True)
        hit = found["primID"] >= 0
        distance = np.where(hit, found["tfar"], np.inf)
        normal = found["Ng"].copy()
        classes = np.where(hit, self.classes[found["primID"]], PERSON + 1)
        paints = np.where(hit, self.paints[found["primID"]], np.iinfo(np.int16).max)
        if body is not None:
            person = body.scene.run(origins, directions, output=True)
            nearer = (person["primID"] >= 0) & (person["tfar"] < distance)
            distance = np.where(nearer, person["tfar"], distance)
            normal[nearer] = person["Ng"][nearer]
            classes[nearer] = PERSON
            paints[nearer] = body.paints[person["primID"][nearer]]
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
        normal *= -np.where((normal * directions).sum(-1, keepdims=True) > 0, 1.0, -1.0)
        point = origins + directions * np.where(np.isfinite(distance), distance, 0.0)[:, None]
        return Hits(distance, normal, classes, paints, point)

    def blocked(
        self,
        points: np.ndarray,
        directions: np.ndarray,
        distances: np.ndarray | float,
        body: Body | None = None,
    ) -> np.ndarray:
        """Flag points (N, 3) with an obstacle within ``distances`` metres along unit directions (N, 3)."""
        points, directions = (np.ascontiguousarray(a, np.float32) for a in (points, directions))
        far = np.broadcast_to(np.asarray(distances, np.float32), len(points)).astype(np.float32)
        shadow = self.solid.run(points, directions, dists=far, query="OCCLUDED") >= 0
        if body is not None:
            shadow |= body.scene.run(points, directions, dists=far, query="OCCLUDED") >= 0
        return shadow


def _scene(triangles: np.ndarray):  # noqa: ANN202
    # Only needed to train Scene GAN; not a dependency of the extension.
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, np.ascontiguousarray(triangles, np.float32))
    return scene
