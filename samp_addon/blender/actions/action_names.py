"""Names of Actions that are made from others."""

from __future__ import annotations

import bpy

LONGEST_NAME = 63
"""Bytes of an Action's name in Blender before 5.0."""


def derived_name(action: bpy.types.Action, suffix: str) -> str:
    """Return an Action's name with a suffix and room for the number that Blender appends to a name in use."""
    room = LONGEST_NAME - len(suffix.encode()) - len(".001")
    return action.name.encode()[:room].decode(errors="ignore") + suffix
