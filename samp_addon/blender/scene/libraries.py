"""Files that the open .blend links."""

from __future__ import annotations

from pathlib import Path

import bpy


def linked() -> list[Path]:
    """Return the .blend files that the open one links, those included that they link themselves."""
    names = (bpy.path.abspath(library.filepath) for library in bpy.data.libraries)
    return sorted({Path(name).resolve() for name in names})
