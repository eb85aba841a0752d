"""A small picture of a take in its scene, for pages with many of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from ...atomic_file import atomic_write
from ...errors import SampError
from ...frames import to_blender
from ..actions import keyframes
from ..rigs import performers
from . import contact_sheet, workbench

EVERY = 10  # frames between those in which a rig of another kind is looked at
MOMENTS, COLUMNS = 4, 2
SIDES = (0.0, -70.0, 65.0, -135.0, 130.0, 180.0)
"""Azimuths, degrees from the usual view, that are tried in this order where furniture or a wall hides the body."""

NEAR = 0.5
"""Metres from the pelvis within which a ray from the camera counts as having met the body."""

TILE = 238
"""Pixels; with the gap, two columns are 480 wide."""


def write(context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action, path: Path) -> None:
    """Write a PNG of 480 x 480 pixels with four moments of a take, from its start to its end.

    The camera is in front of the character, or where furniture and walls hide it least, see best_view.
    Changes the open scene's render settings and frame, and the character's active Action; save the file before. Raise
    SampError where pictures cannot be rendered or written.
    """
    scene = context.scene
    keyframes.activate_action(owner, action)
    track = _track(scene, owner, action)
    first = int(action.frame_range[0])
    moments = np.linspace(0, len(track.pelvis) - 1, MOMENTS).round().astype(int).tolist()
    view = best_view(context, [(first + moment, track.pelvis[moment]) for moment in moments], track)
    tiles = contact_sheet.pictures(
        scene, track, moments, lambda frame: scene.frame_set(first + frame), view, size=(TILE, TILE)
    )
    try:
        with atomic_write(path) as part:
            workbench.write_png(part, contact_sheet.tile(tiles, COLUMNS))
    except (OSError, RuntimeError) as error:
        raise SampError(f"'{path}' cannot be written ({error}); choose another --preview.") from error


def best_view(
    context: bpy.types.Context, moments: Sequence[tuple[int, np.ndarray]], track: contact_sheet.Track
) -> contact_sheet.View:
    """Return the first view of SIDES that sees the body at the most moments. Changes the scene's frame.

    moments: each a frame of the scene and the pelvis (3,) in it. Where the body is hidden at some moments, what stands
    between the camera and the path is cut away.
    """
    usual = contact_sheet.VIEWS[0]
    views = [replace(usual, azimuth=usual.azimuth + side) for side in SIDES]
    seen = np.zeros(len(views), int)
    for frame, pelvis in moments:
        context.scene.frame_set(frame)
        seen += [_is_seen(context, contact_sheet.eye(track, view), Vector(pelvis)) for view in views]
    best = int(seen.argmax())
    return replace(views[best], cut=bool(seen[best] < len(moments)))


def _is_seen(context: bpy.types.Context, eye: Vector, pelvis: Vector) -> bool:
    """Return whether a ray from ``eye`` meets nothing before it is NEAR the pelvis."""
    away = pelvis - eye
    hit, *_ = context.scene.ray_cast(
        context.evaluated_depsgraph_get(), eye, away.normalized(), distance=max(away.length - NEAR, 0.0)
    )
    return not hit


def _track(scene: bpy.types.Scene, owner: bpy.types.Object, action: bpy.types.Action) -> contact_sheet.Track:
    """Return the path of an active take for the camera."""
    if not performers.is_rig(owner):
        return contact_sheet.Track.of(keyframes.read_motion(owner, action, scene=scene))
    first, last = (int(frame) for frame in action.frame_range)
    looked = np.unique(np.append(np.arange(first, last, EVERY), last))
    places = []
    for frame in looked:
        scene.frame_set(int(frame))
        places.append(performers.pelvis_of(owner))
    pelvis, yaws = (np.array(values) for values in zip(*places, strict=True))
    frames = np.arange(first, last + 1)
    along = np.stack([np.interp(frames, looked, pelvis[:, k]) for k in range(3)], -1)
    front = np.interp(frames, looked, np.unwrap(yaws))
    return contact_sheet.Track(to_blender(along), front - math.pi / 2)
