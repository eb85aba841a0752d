"""Readers, one for each file format; `read` chooses by a file's suffix."""

from __future__ import annotations

from pathlib import Path

from ....samp_addon.errors import SampError
from ..recording import Recording
from . import acclaim, bvh, fbx, source

READERS = {".bvh": bvh.read, ".amc": acclaim.read, ".fbx": fbx.read, ".npz": source.read}


def read(path: Path) -> Recording:
    """The motion of a file that holds joints. Raises SampError for files that cannot be read."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise SampError(f"'{path.name}' is of no known format; known are {', '.join(sorted(READERS))}.")
    return reader(path)
