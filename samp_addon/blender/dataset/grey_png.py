"""Grey pictures of 16 bits, exactly as given: Blender's own writer changes colours."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def write(path: Path, values: np.ndarray) -> None:
    """Write values (H, W), uint16, top row first, as a grey PNG of 16 bits. Raise OSError."""
    height, width = values.shape
    rows = values.astype(">u2").view(np.uint8).reshape(height, 2 * width)
    filtered = np.concatenate(
        [np.zeros((height, 1), np.uint8), rows], axis=1
    )  # each row begins with its filter: none
    head = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    path.write_bytes(_SIGNATURE + b"".join(_chunk(kind, data) for kind, data in chunks))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
