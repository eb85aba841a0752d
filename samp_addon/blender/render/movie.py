"""Encodes pictures as a short film."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ...errors import SampError


def write_movie(path: str | Path, pictures: Iterable[np.ndarray], fps: float) -> Path:
    """Write pictures (H, W, 3), uint8, H and W even, as H.264 in an MP4 file.

    Needs the package imageio-ffmpeg, which is part of the development environment but not of the extension.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise SampError("Films need the Python package imageio-ffmpeg: run `make venv`.") from None
    writer = None
    for picture in pictures:
        if writer is None:
            size = (picture.shape[1], picture.shape[0])
            writer = imageio_ffmpeg.write_frames(
                str(path), size, fps=fps, quality=7, macro_block_size=2, ffmpeg_log_level="error"
            )
            writer.send(None)
        writer.send(np.ascontiguousarray(picture))
    if writer is None:
        raise SampError("There are no pictures for the film; render at least one.")
    writer.close()
    return Path(path)
