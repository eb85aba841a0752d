"""Mutual penetration of a body and a piece of furniture (docs: penetration). Piece frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ....samp_addon.scene.distance.orientation import orient_outward
from ....samp_addon.scene.distance.signed_distance import SignedDistance
from ....samp_addon.scene.distance.solids import BoxedTriangles, free_counts
from . import probes

WORTH_A_LOOK = 0.016  # depth (m), estimated from the rest pose, above which the posed skin is measured
_FAR = 3.0  # distance (m) from a piece at which points are outside


@dataclass(eq=False)
class PieceField:
    """The distance field of one piece, and its compression under a body, metres."""

    field: SignedDistance
    give: float

    @classmethod
    def of(cls, triangles: np.ndarray, give: float) -> PieceField:
        """Return the field of triangles (F, 3, 3); its cells are computed on first use."""
        turned = orient_outward(triangles)
        low, high = turned.min((0, 1)), turned.max((0, 1))
        middle = (low + high) / 2
        free = middle + _FAR * np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, -1]])
        return cls(SignedDistance(turned, tuple(free_counts(BoxedTriangles.of(turned), free)), None), give)

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Return signed distances of points (..., 3)."""
        return self.field.at(points.reshape(-1, 3))[0].reshape(points.shape[:-1])

    def skin_depth(self, skin: np.ndarray) -> np.ndarray:
        """Return the depth (T, N) of skin (T, N, 3) inside the piece, 0 outside."""
        return np.maximum(-self.distance(skin), 0.0)

    def surface_depth(self, inside: np.ndarray, root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
        """Return the depth (T, M) of the piece's surface under the skin, at points inside the body (T, M, 3) of poses.

        At a point's distance from the surface there is a surface point that is at least as deep as the point's own
        depth less that distance. The point's depth in a bent body is measured from its posed skin.
        """
        rest = probes.load().depth
        deep = rest > WORTH_A_LOOK + self.give
        away = np.full(inside.shape[:2], np.inf)
        away[:, deep] = np.abs(self.distance(inside[:, deep]))
        under = np.maximum(rest - away, 0.0)
        frames = np.flatnonzero(under.max(1) > WORTH_A_LOOK + self.give)
        for frame, skin in zip(frames, probes.dense(root[frames], rotations[frames]), strict=True):
            some = np.flatnonzero(under[frame] > WORTH_A_LOOK + self.give)
            depth, _ = cKDTree(skin, balanced_tree=False, compact_nodes=False).query(inside[frame, some])
            under[frame, some] = np.maximum(depth - away[frame, some], 0.0)
        return under

    def deepest(self, root: np.ndarray, rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the larger of both depths (T,) in each frame, metres, and the names (T,) of the joints there."""
        skin = self.skin_depth(probes.skinned(root, rotations))
        under = self.surface_depth(probes.interior(root, rotations), root, rotations)
        a, b = skin.max(1), under.max(1)
        names = np.where(a >= b, probes.owners()[skin.argmax(1)], probes.inner_owners()[under.argmax(1)])
        return np.maximum(a, b), names
