"""A small picture of a take in its scene, for pages with many of them."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from ...atomic_file import atomic_write
from ...errors import SampError
from ..actions import keyframes
from . import contact_sheet, workbench

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
    track = contact_sheet.Track.of(keyframes.read_motion(owner, action, scene=scene))
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
