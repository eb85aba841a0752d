"""Atomic writing: a file is complete or absent, whenever the process dies."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a temporary path in the same folder; move it to ``path`` on success, delete it on failure.

    Temporary files that a killed run left behind for the same path are deleted as well. Creates the folder. Raises
    OSError.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield part
        part.replace(path)
    finally:
        # Blender writes its own temporary file: the given name with a character appended.
        for leftover in path.parent.glob(f".{glob.escape(path.stem)}.*.part{glob.escape(path.suffix)}*"):
            leftover.unlink(missing_ok=True)
