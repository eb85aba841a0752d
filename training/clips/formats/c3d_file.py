"""C3D files: labelled markers over time, read by the package ``c3d``."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....samp_addon.errors import SampError

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
FEWEST = 20  # labelled markers needed to solve a body


@dataclass(frozen=True, eq=False)
class Markers:
    """Markers over time.

    places: (T, M, 3) metres, in the file's axes, NaN where a marker is occluded. names: (M,) without the prefix before
    a colon.
    """

    name: str
    fps: float
    names: tuple[str, ...]
    places: np.ndarray


def read(path: Path) -> Markers:
    """Return the markers of a .c3d file. Raise SampError where it cannot be read, or the package is missing."""
    try:
        import c3d
    except ImportError as error:
        raise SampError("C3D files need the Python package 'c3d': pip install c3d.") from error
    try:
        with path.open("rb") as file:
            reader = c3d.Reader(file)
            labels = [label.strip() for label in reader.point_labels]
            unit = reader.get("POINT:UNITS")
            unit = unit.string_value.strip().lower() if unit is not None else "mm"
            fps = float(reader.point_rate)
            points = np.array([frame[1][:, :4] for frame in reader.read_frames(copy=True)])
    except (ValueError, AssertionError, OSError, LookupError, struct.error) as error:
        raise SampError(f"'{path.name}' is not a readable C3D file: {error}.") from error
    if not len(points):
        raise SampError(f"'{path.name}' contains no frames.")
    kept = [k for k, label in enumerate(labels) if label and not re.match(r"[*\W]", label)]
    places = np.where(points[:, kept, 3:] < 0, np.nan, points[:, kept, :3]).astype(np.float64)
    places[(places == 0).all(-1)] = np.nan
    names = tuple(labels[k].split(":")[-1].upper() for k in kept)
    return Markers(path.stem, fps, names, places * METRES.get(unit, 1e-3))
