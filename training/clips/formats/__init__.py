"""Readers, one for each file format; `read` chooses by a file's suffix."""

from __future__ import annotations

from pathlib import Path

from ....samp_addon.errors import SampError
from ..recording import Recording
from . import acclaim, bvh, fbx, source

READERS = {".bvh": bvh.read, ".amc": acclaim.read, ".fbx": fbx.read, ".npz": source.read}


def read(path: Path) -> Recording:
    """Return the motion of a file of joints. Raise SampError for files that cannot be read."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise SampError(f"'{path.name}' has an unknown format; supported are {', '.join(sorted(READERS))}.")
    return reader(path)
