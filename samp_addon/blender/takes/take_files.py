"""Takes from and to files, for the operators."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy

from ... import amass
from ...errors import SampError
from ..actions import keyframes
from ..character import armature


def can_bake(context: bpy.types.Context, explain: Callable[[str], None] = lambda text: None) -> bool:
    """Whether the scene has an SMPL-X armature to work on; ``explain`` gets the reason if not."""
    if context.mode not in {"OBJECT", "POSE"}:
        explain("Go to Object or Pose Mode first")
        return False
    if not any(armature.is_smplx(obj) for obj in context.scene.objects):
        explain("The scene has no SMPL-X armature; create a character first")
        return False
    return True


def bake_file(
    context: bpy.types.Context, path: str, character: str = "", action_name: str = "", frame_start: int = 1
) -> tuple[bpy.types.Object, bpy.types.Action]:
    """Bakes an AMASS file onto a character (see armature.find); returns its armature and the new Action.

    Raises SampError for another file and where there is no such character.
    """
    if not path:
        raise SampError("No file was named; choose an AMASS .npz file.")
    owner = armature.find(context, character)
    take = amass.read_amass(path)
    name = action_name or Path(path).stem
    return owner, keyframes.write_motion(owner, take, name, frame_start, context.scene)


def export_file(context: bpy.types.Context, path: str, character: str = "", action_name: str = "") -> Path:
    """Writes a character's Action, the active one if unnamed, as an AMASS file; returns where.

    Raises SampError where there is no such character or Action, or the file cannot be written.
    """
    if not path:
        raise SampError("No file was named; choose where to write the .npz file.")
    owner = armature.find(context, character)
    action = None
    if action_name:
        action = bpy.data.actions.get(action_name)
        if action is None:
            raise SampError(f"There is no Action '{action_name}'; choose one that the file holds.")
    return amass.write_amass(keyframes.read_motion(owner, action, scene=context.scene), path)
