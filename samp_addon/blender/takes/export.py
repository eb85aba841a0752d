"""A character and its take in other programs' files, by Blender's own exporters."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from ...errors import SampError
from .. import compat
from ..character import armature
from . import amass_files

SUFFIXES = {"NPZ": ".npz", "FBX": ".fbx", "BVH": ".bvh", "USD": ".usdc", "GLTF": ".glb"}


def export_take(context: bpy.types.Context, path: str, kind: str = "FBX", character: str = "") -> Path:
    """Writes a character, its meshes and its active Action; returns where.

    kind: a key of SUFFIXES; the file's suffix is put right. Selection and active object stay as they are. Raises
    SampError where there is no such character or Action, or the file cannot be written.
    """
    if not path:
        raise SampError("No file was named; choose where to write it.")
    if kind not in SUFFIXES:
        raise SampError(f"There is no format '{kind}'; choose one of {', '.join(SUFFIXES)}.")
    target = Path(bpy.path.abspath(path)).with_suffix(SUFFIXES[kind])
    if kind == "NPZ":
        return amass_files.export_take(context, str(target), character)
    owner = armature.find(context, character)
    data = owner.animation_data
    if data is None or data.action is None:
        raise SampError(f"'{owner.name}' has no Action; generate or choose a take first.")
    first, last = (round(frame) for frame in data.action.frame_range)
    with _only(context, owner), _frames(context.scene, first, last):
        try:
            compat.export(kind, str(target), first, last)
        except (RuntimeError, OSError, AttributeError) as error:
            raise SampError(
                f"'{target}' cannot be written ({_first_line(error)}); choose another file."
            ) from error
    if not target.is_file():
        raise SampError(f"'{target}' was not written; choose another file.")
    return target


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[-1]


@contextmanager
def _only(context: bpy.types.Context, owner: bpy.types.Object) -> Iterator[None]:
    """The character and its meshes selected and nothing else; afterwards as it was."""
    layer = context.view_layer
    active, selected = layer.objects.active, list(context.selected_objects)
    parts = [owner, *(obj for obj in owner.children_recursive if obj.type == "MESH")]
    try:
        for thing in selected:
            thing.select_set(False)
        for thing in parts:
            if thing.name in layer.objects:
                thing.select_set(True)
        layer.objects.active = owner
        yield
    finally:
        for thing in parts:
            if thing.name in layer.objects:
                thing.select_set(False)
        for thing in selected:
            thing.select_set(True)
        layer.objects.active = active


@contextmanager
def _frames(scene: bpy.types.Scene, first: int, last: int) -> Iterator[None]:
    """The scene's frame range set to the take's; afterwards as it was."""
    kept = scene.frame_start, scene.frame_end, scene.frame_current
    try:
        scene.frame_start, scene.frame_end = max(first, 0), last
        yield
    finally:
        scene.frame_start, scene.frame_end = kept[:2]
        scene.frame_set(kept[2])
