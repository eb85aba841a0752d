"""Takes from and to AMASS .npz files."""

from __future__ import annotations

from pathlib import Path

import bpy

from ...body import amass
from ...errors import SampError
from ..actions import keyframes
from ..character import armature


def import_take(
    context: bpy.types.Context, path: str, character: str = "", action_name: str = "", frame_start: int = 1
) -> tuple[bpy.types.Object, bpy.types.Action]:
    """Bake an AMASS file onto a character (see armature.find); return its armature and the new Action.

    Raise SampError for a file of another kind and where there is no such character.
    """
    if not path:
        raise SampError("No file was named; choose an AMASS .npz file.")
    owner = armature.find(context, character)
    motion = amass.read_amass(path)
    name = action_name or Path(path).stem
    return owner, keyframes.write_motion(owner, motion, name, frame_start, context.scene)


def export_take(context: bpy.types.Context, path: str, character: str = "", action_name: str = "") -> Path:
    """Write a character's Action, by default the active one, as an AMASS file and return its path.

    Raise SampError where there is no such character or Action, or the file cannot be written.
    """
    if not path:
        raise SampError("No file was named; choose where to write the .npz file.")
    owner, action = keyframes.find_action(context, character, action_name)
    return amass.write_amass(keyframes.read_motion(owner, action, scene=context.scene), path)
