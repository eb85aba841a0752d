"""What MotionNet's weights file says of itself, read without torch: the panel asks at every redraw."""

from __future__ import annotations

import functools
import json
import struct
from pathlib import Path

FILE = Path(__file__).parents[3] / "models" / "weights" / "motion_net.safetensors"
MOST = 1 << 20
"""Bytes of a header beyond which the file is not what it should be."""


def knows_postures(path: Path = FILE) -> bool:
    """Return whether the weights know postures of rests; False for a file that cannot be read."""
    try:
        return _knows_postures(path, path.stat().st_mtime_ns)
    except (OSError, ValueError, struct.error):
        return False


@functools.lru_cache(maxsize=4)
def _knows_postures(path: Path, modified: int) -> bool:
    """modified: of the file, which only has to differ between contents."""
    with path.open("rb") as file:
        (length,) = struct.unpack("<Q", file.read(8))
        return length <= MOST and "posture_rows" in json.loads(file.read(length))
