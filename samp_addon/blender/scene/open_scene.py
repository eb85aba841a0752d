"""Opens a scene file for the batch: Blender's own, or one of the formats in which furniture is passed on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy

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
