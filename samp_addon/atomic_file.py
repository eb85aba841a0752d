"""Files that are whole or not there at all, whenever the process dies."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A place beside the file to write to; moved to the file's own if nothing went wrong, else taken away.

    What a killed run has left of the same file is taken away too. Makes the folder. Raises OSError.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield part
        part.replace(path)
    finally:
        # Blender itself writes beside the name it is given, with a sign after it.
        for left in path.parent.glob(f".{glob.escape(path.stem)}.*.part{glob.escape(path.suffix)}*"):
            left.unlink(missing_ok=True)
