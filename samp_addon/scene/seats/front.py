"""The main axis of a piece of furniture, from its geometry alone."""

from __future__ import annotations

import numpy as np

from .. import geometry


def dominant_axis(triangles: np.ndarray) -> float:
    """Return the yaw in [0, pi/2) radians along whose quarter turns most of an object's upright surface faces.

    This is the mean of the normals' yaws modulo a quarter turn, weighted by area and by how upright each face is; the
    left and right halves of tapered or curved furniture cancel. For round objects it is arbitrary but reproducible.
    triangles: (F, 3, 3) metres, network frame.
    """
    normal = geometry.area_vectors(triangles)
    weight = np.hypot(normal[:, 0], normal[:, 2])
    four = 4 * np.arctan2(normal[:, 0], normal[:, 2])
    mean = np.sum(weight * np.exp(1j * four))
    if np.abs(mean) < 0.05 * max(weight.sum(), 1e-12):
        mean = _from_extent(triangles)
    return float(np.angle(mean) / 4 % (np.pi / 2))


def _from_extent(triangles: np.ndarray) -> complex:
    """Return the same mean, as a complex number, from the surface's second moment: for sheets without upright faces."""
    area = geometry.areas(triangles)
    flat = triangles[..., [0, 2]]
    flat = flat - (area @ flat.mean(axis=1)) / max(area.sum(), 1e-12)
    total = flat.sum(axis=1)
    moment = np.einsum("f,fki,fkj->ij", area, flat, flat) + np.einsum("f,fi,fj->ij", area, total, total)
    two = np.arctan2(2 * moment[0, 1], moment[1, 1] - moment[0, 0])
    return complex(np.exp(2j * two))
