"""Packs the files that a .blend links, by the package blender-asset-tracer where it is installed."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from ....errors import SampError
from ....progress import Progress

PACKAGE, DISTRIBUTION = "blender_asset_tracer", "blender-asset-tracer"
FOLDER = "scene"


def available() -> bool:
    """Return whether the package is installed."""
    return importlib.util.find_spec(PACKAGE) is not None


def pack(scene: Path, home: Path, linked: list[Path], progress: Progress = lambda stage, share: None) -> Path:
    """Copy a .blend and all that it uses into the folder `scene` beside it; return the copy. Raise SampError.

    home: folder of the artist's file. linked: the libraries; what is under the folder that holds them and home keeps
    its place there. The given .blend is deleted.
    """
    from blender_asset_tracer.pack import Packer

    progress("Packing linked files", 0.2)
    project = Path(os.path.commonpath([scene.parent, home, *(path.parent for path in linked)]))
    try:
        with Packer(scene, project, str(scene.parent / FOLDER)) as packer:
            packer.strategise()
            packer.execute()
            missing, made = sorted(map(str, packer.missing_files)), Path(str(packer.output_path))
    # The package reads files of any kind and age, and may raise anything.
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SampError(
            f"The linked files cannot be packed ({reason}); make them local in Blender."
        ) from error
    if missing:
        raise SampError(f"The file '{missing[0]}' is missing; find it in Blender, or remove what uses it.")
    scene.unlink()
    return made
