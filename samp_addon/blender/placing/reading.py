"""The artist's scene, read once, as what is aimed at (pipeline/placing.py)."""

from __future__ import annotations

import bpy
import numpy as np

from ... import frames
from ...pipeline.placing import Placer, PosturesAt, Spot
from ...scene.rays import Hit
from ..cast import others
from ..character import characters
from ..overlays import start_marker
from ..scene import candidates, read_scene, targets
from ..scene.targets import view_ray

ABOVE = 0.05
"""Metres over a point from which the surface below it is looked for."""

BELOW = 0.3
"""Metres below a point within which it is."""


def read(
    context: bpy.types.Context, owner: bpy.types.Object | None, postures_at: PosturesAt | None = None
) -> Placer:
    """Return what answers where bodies would be.

    owner: the character; None where one is to be made. postures_at: of the method that takes are made with.
    """
    people = characters.people(context)
    people += others.moving(context, people, (owner,))
    geometry = read_scene.read_scene(context, people)
    start = None if owner is None else start_marker.place(context, owner)[0]
    present = others.present(context, people, (owner,))
    return Placer(
        geometry, _Targets(context.scene), present, start, postures_at or (lambda goal, triangles: ())
    )


def under_mouse(
    context: bpy.types.Context, placer: Placer, x: int, y: int, choice: int = 0, yaw: float | None = None
) -> tuple[Spot | None, Hit | None]:
    """Return the spot under a place of the window, pixels, and the surface there; see Placer.at."""
    ray = view_ray(context, x, y)
    if ray is None:
        return None, None
    hit = placer.rays.first(*(frames.to_network(np.array(vector)) for vector in ray))
    return (None, None) if hit is None else (placer.at(hit, choice, yaw), hit)


def at_point(placer: Placer, point: np.ndarray, choice: int = 0, yaw: float | None = None) -> Spot | None:
    """Return the spot on the surface at, or right below, a point (3,) of Blender's world; None where there is none."""
    place = frames.to_network(np.asarray(point, float))
    hit = placer.rays.first(place + [0.0, ABOVE, 0.0], np.array([0.0, -1.0, 0.0]))
    if hit is None or place[1] - hit.point[1] > BELOW:
        return None
    return placer.at(hit, choice, yaw)


def facing(context: bpy.types.Context, spot: Spot, x: int, y: int) -> float | None:
    """Return the yaw from a spot to where a place of the window, pixels, is on the same level; None where it is not."""
    ray = view_ray(context, x, y)
    if ray is None:
        return None
    origin, direction = (frames.to_network(np.array(vector)) for vector in ray)
    if abs(direction[1]) < 1e-6:
        return None
    share = (spot.point[1] - origin[1]) / direction[1]
    away = origin + share * direction - spot.point
    if share <= 0 or np.linalg.norm(away[[0, 2]]) < 1e-3:
        return None
    return float(frames.direction_yaw(away))


class _Targets:
    """The target that an object belongs to, by name; see pipeline.placing.TargetOf."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        self.objects = scene.objects
        self._known: dict[str, tuple[str, tuple[str, ...]] | None] = {}

    def __call__(self, name: str) -> tuple[str, tuple[str, ...]] | None:
        if name not in self._known:
            self._known[name] = self._find(name)
        return self._known[name]

    def _find(self, name: str) -> tuple[str, tuple[str, ...]] | None:
        obj = self.objects.get(name)
        if obj is None:
            return name, (name,)  # a member of a collection instance
        if not candidates.is_furniture(obj):
            return None
        whole = targets.whole(obj)
        return whole.name, (whole.name, *(child.name for child in whole.children_recursive))
