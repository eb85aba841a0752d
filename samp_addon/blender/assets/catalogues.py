"""Catalogues of an asset library: lines UUID:PATH:NAME in the text file that Blender keeps in the library's folder."""

from __future__ import annotations

import uuid
from pathlib import Path

from ...atomic_file import atomic_write
from ...errors import SampError

FILE = "blender_assets.cats.txt"
HEADER = "# This is an Asset Catalog Definition file for Blender.\n\nVERSION 1\n\n"
_NAMESPACE = uuid.UUID("0d9e3ee2-8b0c-4d0a-9f7e-6d1f3a5b7c21")


def ensure(folder: Path, path: str) -> str:
    """Return the UUID of the catalogue at a path such as "SAMP/Takes"; a missing one is added to the library's file.

    folder: of the library. All other lines of the file stay as they are. Raise SampError where the file cannot be read
    or written.
    """
    file = folder / FILE
    try:
        text = file.read_text("utf-8") if file.exists() else HEADER
        for line in text.splitlines():
            parts = line.split(":")
            if len(parts) == 3 and parts[1] == path:
                return parts[0]
        made = str(uuid.uuid5(_NAMESPACE, path))  # the same one in every library
        text += "" if text.endswith("\n") else "\n"
        with atomic_write(file) as part:
            part.write_text(f"{text}{made}:{path}:{path.replace('/', '-')}\n", "utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SampError(
            f"The catalogues in '{file}' cannot be changed ({error}); choose another folder."
        ) from error
    return made
