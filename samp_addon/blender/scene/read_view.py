"""The artist's scene as a step's method sees it: only what the method needs is read."""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy
import numpy as np

from ... import frames
from ...methods import registry
from ...methods.scene_view import SceneView
from ...methods.step import Step
from ...scene.geometry import SceneGeometry
from ...vocabulary import SEATED
from ..overlays import goal_arrows, waypoints
from ..placing import strokes
from ..render import camera_picture
from ..rigs import performers
from ..sub_goals import placing
from . import pieces, read_scene

Place = tuple[np.ndarray, float | None]
"""Floor position (3,) and yaw in radians, network frame."""


def read_view(
    context: bpy.types.Context,
    step: Step,
    geometry: SceneGeometry,
    start: Place | None,
    people: Sequence[bpy.types.Object],
    first: bool,
    owner: bpy.types.Object | None = None,
) -> SceneView:
    """Return what a step's method needs of the scene.

    geometry: of all furniture. start: where the character starts. people: characters, which are no furniture. first:
    whether it is the job's first step, whose path passes the artist's way-points. owner: the character whose sub-goals
    are passed by a step without any and without an action. Raise SampError where the target is missing.
    """
    needs, found = registry.find(step.method).needs, {}
    if step.target and "target" in needs:
        target = read_scene.read_target(context, step.target, people)
        if step.action in SEATED:
            point = None if step.point is None else frames.to_network(np.array(step.point[:3]))
            geometry, target = pieces.piece(context, geometry, target, step.action, point)
            found["characters"] = pieces.characters(context)
        found |= {"target": target.triangles, "parts": target.parts}
        if "goals" in needs:
            found["goals"] = goal_arrows.read_goals(context, target, step.action, geometry)
            if step.action in SEATED and step.point is not None and len(step.point) > 3:
                found["goals"] = [goal_arrows.goal_at(target, step.action, *place(step.point))]
    if step.to is not None and "destination" in needs:
        found["destination"] = place(step.to)
    if "start" in needs:
        found["start"] = start
    camera = step.settings.get("camera") or ""
    if "camera" in needs and (camera or context.scene.camera is not None):
        found["camera"] = camera_picture.take(context, camera, geometry)
    if first and "via" in needs:
        found["via"] = [frames.to_network(np.array(p)) for p in step.via]
        found["via"] += [] if not step.path else [*frames.to_network(strokes.of_curve(context, step.path))]
        found["via"] = found["via"] or waypoints.positions(context)
    if "sub_goals" in needs:
        found["sub_goals"] = [place(numbers) for numbers in step.settings.get("sub_goals") or ()]
        if passes_stored(step):
            found["sub_goals"], found["bodies"] = placing.chosen(context, owner)
    return SceneView(geometry, **found)


def passes_stored(step: Step) -> bool:
    """Return whether a step passes the sub-goals that are stored with the character."""
    needed = "sub_goals" in registry.find(step.method).needs
    return needed and not step.action and not step.settings.get("sub_goals")


def start_of(start: Sequence[float] | None, owner: bpy.types.Object | None) -> Place | None:
    """Return where the character starts: as asked for, or where it stands, or None."""
    if start is not None:
        return place(start)
    if owner is None:
        return None
    return performers.standing_floor(owner)


def place(numbers: Sequence[float]) -> Place:
    """Return the place of (x, y, z) or (x, y, z, yaw) in Blender's world, yaw in degrees."""
    yaw = math.radians(numbers[3]) if len(numbers) > 3 else None
    return frames.to_network(np.array(numbers[:3])), yaw
