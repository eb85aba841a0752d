"""A small picture of a take in its scene, for pages with many of them."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np

from ...atomic_file import atomic_write
from ...errors import SampError
from ...frames import to_blender
from ..actions import keyframes
from ..rigs import performers
from . import contact_sheet, workbench

EVERY = 10  # frames between those in which a rig of another kind is looked at
MOMENTS, COLUMNS = 4, 2
TILE = 238
"""Pixels; with the gap, two columns are 480 wide."""


def write(context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action, path: Path) -> None:
    """Write a PNG of 480 x 480 pixels: four moments of a take, from its start to its end, seen from the front.

    Changes the open scene's render settings and frame, and the character's active Action; save the file before. Raise
    SampError where pictures cannot be rendered or written.
    """
    scene = context.scene
    keyframes.activate_action(owner, action)
    track = _track(scene, owner, action)
    first = int(action.frame_range[0])
    moments = np.linspace(0, len(track.pelvis) - 1, MOMENTS).round().astype(int).tolist()
    tiles = contact_sheet.pictures(
        scene,
        track,
        moments,
        lambda frame: scene.frame_set(first + frame),
        contact_sheet.VIEWS[0],
        size=(TILE, TILE),
    )
    try:
        with atomic_write(path) as part:
            workbench.write_png(part, contact_sheet.tile(tiles, COLUMNS))
    except (OSError, RuntimeError) as error:
        raise SampError(f"'{path}' cannot be written ({error}); choose another --preview.") from error


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
