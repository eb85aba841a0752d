"""Opens and saves files for the batch: Blender's own, and the formats in which furniture is passed on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy

from ...atomic_file import whole
from ...errors import SampError
from .. import compat


def _gltf(filepath: str) -> None:
    import addon_utils

    # An add-on that ships with Blender; an artist may have switched it off.
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
FORMATS = (".blend", *IMPORTERS)


def open_scene(path: str | Path) -> None:
    """Opens a .blend, or imports another format into an empty file. What is open now is discarded.

    Raises SampError for a missing file, an unknown format, an unreadable file, and one without objects.
    """
    path = Path(path).expanduser().resolve()
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise SampError(f"'{path.name}' is no scene file; give one of {', '.join(FORMATS)}.")
    if not path.is_file():
        raise SampError(f"There is no file '{path}'; check the path.")
    try:
        if kind == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
            return
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        IMPORTERS[kind](str(path))
    # Importers are add-ons of many hands: whatever they trip over, the file is what the artist can look at.
    except Exception as error:
        reason = (str(error).strip().splitlines() or [""])[0].removeprefix("Error: ").rstrip(".")
        raise SampError(f"'{path.name}' cannot be read{': ' + reason if reason else ''}.") from error
    if not bpy.context.scene.objects:
        raise SampError(f"'{path.name}' cannot be read, or holds no objects; open it in Blender to see.")


def open_for_job(path: Path | None) -> bpy.types.Context:
    """Open a scene's file, or the open file afresh, so that no job finds what another one has made.

    Return the context. Raise SampError as `open_scene`.
    """
    if path is not None:
        open_scene(path)
    elif bpy.data.filepath:
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
    return bpy.context


def is_open() -> bool:
    """Whether a scene is open already: a file's, or the one of a Blender that is not just a Python module."""
    return bool(bpy.data.filepath or bpy.app.binary_path)


def open_file() -> Path | None:
    """Return the file that is open, or None where it was never saved."""
    return Path(bpy.data.filepath) if bpy.data.filepath else None


def save_copy(path: Path) -> None:
    """Write the open file as a .blend. Raise SampError where it cannot be written."""
    try:
        with whole(path) as part:
            bpy.ops.wm.save_as_mainfile(filepath=str(part.absolute()), copy=True, check_existing=False)
    except (RuntimeError, OSError) as error:
        reason = str(error).strip().removeprefix("Error: ").rstrip(".")
        raise SampError(f"'{path}' cannot be written ({reason}); choose another --output.") from error
