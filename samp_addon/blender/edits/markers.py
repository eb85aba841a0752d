"""Markers at the phases and steps of a take, on its Action, so that they travel with it."""

from __future__ import annotations

import bpy

from ...edits import marks
from ..actions import keyframes, notes

KEY = "samp_markers"
"""Names of the markers that are the add-on's, a line each."""


def mark(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    action: bpy.types.Action,
    phases: bool = True,
    steps: bool = False,
) -> int:
    """Add pose markers to a take where its phases begin and where its feet come down; return their number.

    Markers of an earlier call are replaced; the artist's own stay.
    """
    first = round(action.frame_range[0])
    motion = keyframes.read_motion(owner, action, first, notes.take_end(action), context.scene)
    found = (marks.phases(motion) if phases else []) + (marks.steps(motion) if steps else [])
    own = set(str(action.get(KEY, "")).split("\n"))
    for marker in list(action.pose_markers):
        if _named(marker) in own:
            action.pose_markers.remove(marker)
    made = []
    for frame, name in sorted(found):
        marker = action.pose_markers.new(name)
        marker.frame = first + frame
        made.append(_named(marker))
    action[KEY] = "\n".join(made)
    return len(found)


def _named(marker: bpy.types.TimelineMarker) -> str:
    """Return a marker's name and frame: one that the artist renamed or moved is theirs."""
    return f"{marker.frame} {marker.name}"
