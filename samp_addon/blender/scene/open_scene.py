"""Opens and saves files for the batch: a .blend, or an interchange format to import."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import bpy
from mathutils import Matrix

from ...atomic_file import atomic_write
from ...errors import SampError
from .. import compat


def _gltf(filepath: str) -> None:
    import addon_utils

    # The importer is a bundled add-on that an artist may have disabled.
    addon_utils.enable("io_scene_gltf2", default_set=False)
    bpy.ops.import_scene.gltf(filepath=filepath)


def _obj(filepath: str) -> None:
    bpy.ops.wm.obj_import(filepath=filepath)


IMPORTERS: dict[str, Callable[[str], None]] = {
    ".glb": _gltf,
    ".gltf": _gltf,
    ".obj": _obj,
    ".fbx": compat.import_fbx,
    ".usd": compat.import_usd,
    ".usda": compat.import_usd,
    ".usdc": compat.import_usd,
    ".usdz": compat.import_usd,
}
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Metres of each unit that an imported file can be in."""

CONVERTED_KEY = "samp_converted"
"""Custom property of a scene whose units or axes were given."""

FORMATS = (".blend", *IMPORTERS)


def open_scene(path: str | Path) -> None:
    """Open a .blend, or import another format into an empty file. The current file is discarded.

    Raise SampError for a missing file, an unknown format, an unreadable file, and one without objects.
    """
    path = Path(path).expanduser().resolve()
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise SampError(f"'{path.name}' is not a scene file; use one of {', '.join(FORMATS)}.")
    if not path.is_file():
        raise SampError(f"There is no file '{path}'; check the path.")
    try:
        if kind == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
            leave_modes()
            return
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        IMPORTERS[kind](str(path))
    # Importers are add-ons and may raise anything; the user can only check the file.
    except Exception as error:
        reason = (str(error).strip().splitlines() or [""])[0].removeprefix("Error: ").rstrip(".")
        raise SampError(f"'{path.name}' cannot be read{': ' + reason if reason else ''}.") from error
    if not bpy.context.scene.objects:
        raise SampError(f"'{path.name}' has no objects or cannot be read; open it in Blender to check.")


def open_for_job(path: Path | None, units: str | None = None, up: str | None = None) -> bpy.types.Context:
    """Open a file afresh, so that no job finds what another one has made; None is the scene of a Blender that was
    never saved.

    units, up: of an imported file, a key of METRES and the axis "Y" or "Z" that points up in it. Return the context.
    Raise SampError as `open_scene`.
    """
    if path is not None:
        open_scene(path)
        if units or up:
            _convert(bpy.context.scene, METRES[units or "m"], up == "Z")
            bpy.context.scene[CONVERTED_KEY] = " ".join(filter(None, (units, up)))
    return bpy.context


def _convert(scene: bpy.types.Scene, metres: float, turned: bool) -> None:
    """Scale an imported scene to metres, and turn it upright where the importer expected Y up and the file has Z up."""
    change = Matrix.Scale(metres, 4)
    if turned:
        change = Matrix.Rotation(math.radians(-90), 4, "X") @ change
    bpy.context.view_layer.update()
    for obj in scene.objects:
        if obj.parent is None:
            obj.matrix_world = change @ obj.matrix_world
    bpy.context.view_layer.update()


def leave_modes() -> None:
    """Go to Object Mode: a file may have been saved in Edit, Sculpt or Weight Paint Mode."""
    if bpy.context.mode != "OBJECT" and bpy.ops.object.mode_set.poll():
        bpy.ops.object.mode_set(mode="OBJECT")


def is_open() -> bool:
    """Return whether a scene is open: a file's, or that of a Blender application rather than the Python module."""
    return bool(bpy.data.filepath or bpy.app.binary_path)


def open_file() -> Path | None:
    """Return the file that is open, or None where it was never saved."""
    return Path(bpy.data.filepath) if bpy.data.filepath else None


def save_copy(path: Path, advice: str = "choose another --output") -> None:
    """Write the open file as a .blend, whose relative names lead where they led. Raise SampError where it cannot be
    written. advice: the end of the error's sentence."""
    try:
        with atomic_write(path) as part:
            bpy.ops.wm.save_as_mainfile(filepath=str(part.absolute()), copy=True, check_existing=False)
    except (RuntimeError, OSError) as error:
        reason = str(error).strip().removeprefix("Error: ").rstrip(".")
        raise SampError(f"'{path}' cannot be written ({reason}); {advice}.") from error
