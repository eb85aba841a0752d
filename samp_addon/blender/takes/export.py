"""Exports a character with its take, by Blender's own exporters."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from ...errors import SampError
from .. import compat
from ..actions import keyframes
from . import amass_files

SUFFIXES = {"NPZ": ".npz", "FBX": ".fbx", "BVH": ".bvh", "USD": ".usdc", "GLTF": ".glb"}


def export_take(context: bpy.types.Context, path: str, kind: str = "FBX", character: str = "") -> Path:
    """Write a character, its meshes and its active Action to a file and return its path.

    kind: a key of SUFFIXES, which sets the file's suffix. Selection and active object do not change. Raise SampError
    where there is no such character or Action, or the file cannot be written.
    """
    if not path:
        raise SampError("No file was named; choose where to write it.")
    if kind not in SUFFIXES:
        raise SampError(f"There is no format '{kind}'; choose one of {', '.join(SUFFIXES)}.")
    target = Path(bpy.path.abspath(path)).with_suffix(SUFFIXES[kind])
    if kind == "NPZ":
        return amass_files.export_take(context, str(target), character)
    owner, action = keyframes.find_action(context, character)
    first, last = (round(frame) for frame in action.frame_range)
    with _selected(context, owner), _frame_range(context.scene, first, last):
        try:
            compat.export(kind, str(target), first, last)
        except (RuntimeError, OSError, AttributeError) as error:
            raise SampError(
                f"'{target}' cannot be written ({_first_line(error)}); choose another file."
            ) from error
    if not target.is_file():
        raise SampError(f"'{target}' was not written; choose another file.")
    return target


def file_stem(context: bpy.types.Context, character: str = "", action_name: str = "") -> str:
    """Return the name of a file for a character's Action, by default the active one: the Action's own."""
    try:
        _, action = keyframes.find_action(context, character, action_name)
    except SampError:  # reported when the file is written
        return "take"
    return bpy.path.clean_name(action.name, replace="-")


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[-1]


@contextmanager
def _selected(context: bpy.types.Context, owner: bpy.types.Object) -> Iterator[None]:
    """Select only the character and its meshes; restore the selection afterwards."""
    layer = context.view_layer
    active, selected = layer.objects.active, list(context.selected_objects)
    parts = [owner, *(obj for obj in owner.children_recursive if obj.type == "MESH")]
    try:
        for obj in selected:
            obj.select_set(False)
        for obj in parts:
            if obj.name in layer.objects:
                obj.select_set(True)
        layer.objects.active = owner
        yield
    finally:
        for obj in parts:
            if obj.name in layer.objects:
                obj.select_set(False)
        for obj in selected:
            obj.select_set(True)
        layer.objects.active = active


@contextmanager
def _frame_range(scene: bpy.types.Scene, first: int, last: int) -> Iterator[None]:
    """Set the scene's frame range to the take's; restore it afterwards."""
    before = scene.frame_start, scene.frame_end, scene.frame_current
    try:
        scene.frame_start, scene.frame_end = max(first, 0), last
        yield
    finally:
        scene.frame_start, scene.frame_end = before[:2]
        scene.frame_set(before[2])
