"""The start of a character's takes as an arrow on the floor, to move and turn like any object."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy
import numpy as np
from mathutils import Matrix

from ... import frames
from ...pipeline.job import Job
from ..character import start
from ..character.start import Place
from ..rigs import performers
from ..scene.candidates import OVERLAY_KEY

MARKER_KEY = "samp_start_marker"
"""Custom property of a start marker, which is a child of its character."""
LENGTH = 0.5


def show(context: bpy.types.Context, owner: bpy.types.Object) -> bpy.types.Object:
    """Put a character's marker at its stored start and return it; create start and marker if they are missing."""
    context.view_layer.update()
    if start.stored(owner) is None:
        start.store(owner, _first(owner))
    marker = find(owner) or _create(context, owner)
    marker.matrix_world = _matrix(start.stored(owner))
    context.view_layer.update()
    return marker


def find(owner: bpy.types.Object) -> bpy.types.Object | None:
    """Return a character's marker, or None."""
    return next((child for child in owner.children if MARKER_KEY in child), None)


def place(context: bpy.types.Context, owner: bpy.types.Object) -> Place:
    """Return where a character's next take starts: its marker, else the stored start, else where it stands."""
    context.view_layer.update()  # matrix_world is stale after a script moved the character
    marker = find(owner)
    if marker is not None:
        world = np.array(marker.matrix_world, dtype=np.float64)
        ahead = frames.to_network(world[:3, 2])
        if np.linalg.norm(ahead[[0, 2]]) > 1e-6:
            return frames.to_network(world[:3, 3]), float(frames.direction_yaw(ahead))
    return start.stored(owner) or _first(owner)


def at_marker(context: bpy.types.Context, job: Job, owner: bpy.types.Object | None) -> Job:
    """Return the job with the character's marker as its start, unless it has a start of its own."""
    if owner is None or job.start is not None:
        return job
    position, yaw = place(context, owner)
    return replace(job, start=(*map(float, frames.to_blender(position)), math.degrees(yaw)))


def _first(owner: bpy.types.Object) -> Place:
    return performers.standing_floor(owner) if performers.is_rig(owner) else start.first_start(owner)


def _create(context: bpy.types.Context, owner: bpy.types.Object) -> bpy.types.Object:
    marker = bpy.data.objects.new(f"Start of {owner.name}", None)
    marker.empty_display_type, marker.empty_display_size = "SINGLE_ARROW", LENGTH
    marker.show_in_front, marker.hide_render = True, True
    marker[OVERLAY_KEY] = marker[MARKER_KEY] = True
    homes = [collection for collection in owner.users_collection if collection.is_editable]
    (homes[0] if homes else context.scene.collection).objects.link(marker)
    marker.parent = owner
    return marker


def _matrix(where: Place) -> Matrix:
    """Return the world matrix of a marker: local Z along the facing, local X up."""
    position, yaw = where
    ahead, up = frames.to_blender(frames.yaw_direction(yaw)), np.array([0.0, 0.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([up, np.cross(ahead, up), ahead], axis=1)
    matrix[:3, 3] = frames.to_blender(position)
    return Matrix(matrix.tolist())
