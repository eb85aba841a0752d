"""Thin things that pass through a body: samples of the scene's surface, pushed to the nearest skin. Imports torch.

Solids push vertices out (field.py); a seat of one sheet, a slat or a wire has no inside, and vertices pass it unseen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from ..body import human
from ..body.hands import complete
from ..body.human import Human
from ..evaluation.skin_depth import SkinSurface, surface_of
from ..motion import Motion
from ..scene.distance.surface_samples import samples_in_box
from ..scene.geometry import extent
from ..skeleton import forward_kinematics
from .pose import Skin

SPACING = 0.02
"""Metres between samples; coarser than for the measures."""

CLEARANCE = 0.004
"""Metres that are kept between a sample that was inside and the skin."""

SOLE_THICKNESS, SOLE_GIVE = 0.02, 0.016
"""Metres: the soles are put onto the ground afterwards, see feet/."""

REACH = 0.3
"""Metres around the take that it may be moved through."""

CARPET = 0.01
"""Metres over the floor up to which surfaces belong to it."""


@dataclass(frozen=True)
class Pierced:
    """Samples inside the body as last looked at. row, vertex: (N,) of the sampled frame and the nearest skin. place,
    out: (N, 3) where that skin was and the direction to it. depth: (N,) metres. skin: of all vertices."""

    row: torch.Tensor
    vertex: torch.Tensor
    place: torch.Tensor
    out: torch.Tensor
    depth: torch.Tensor
    skin: Skin

    def depth_at(self, transforms: torch.Tensor) -> torch.Tensor:
        """Return the depths (N,) under other transforms (R, 55, 3, 4) of the joints, linear in the skin's place."""
        moved = self.skin.at(transforms, self.row, self.vertex) - self.place
        return self.depth + (moved * self.out).sum(-1)


class ThinThings:
    """Samples (N, 3) of the surfaces around a take. give: (N,) metres by which their objects yield."""

    def __init__(self, samples: np.ndarray, give: np.ndarray, body: Human) -> None:
        self.samples, self.give, self.body = samples, give, body
        self.surface: SkinSurface = surface_of(body)
        self.skin = Skin(body, np.arange(len(body.vertices)))
        self._yields = np.where(body.vertices[:, 1] < body.floor + SOLE_THICKNESS, SOLE_GIVE, 0.0)

    @classmethod
    def around(
        cls, motion: Motion, triangles: np.ndarray, give: np.ndarray, body: Human, floor: float | None
    ) -> ThinThings | None:
        """Sample what a take comes near, without the floor; None where there is nothing.

        triangles: (F, 3, 3). give: (F,) metres by which they yield. floor: its height, metres, or None.
        """
        reach = surface_of(body).reach + REACH
        low, high = extent(_joints(motion, body))
        samples, owners = samples_in_box(triangles, low - reach, high + reach, SPACING)
        if floor is not None:
            above = samples[:, 1] > floor + CARPET
            samples, owners = samples[above], owners[above]
        return cls(samples, give[owners], body) if len(samples) else None

    def deepest(self, motion: Motion) -> float:
        """Return the largest depth of a sample in the body, metres; 0 where the body is free."""
        found = self.pierced(motion)
        return 0.0 if found is None else max(float(found.depth.max()) - CLEARANCE, 0.0)

    def pierced(self, motion: Motion) -> Pierced | None:
        """Return the samples inside the body in all frames of a motion; None where there are none."""
        joints = _joints(motion, self.body)
        close = [self.surface.near(one, self.samples) for one in joints]
        frames = [k for k, near in enumerate(close) if len(near)]
        if not frames:
            return None
        skins = human.skin(self.body, motion.pose_slice(np.array(frames)), self.surface.vertices)
        whole = np.full(len(self.body.vertices), -1)
        whole[self.surface.vertices] = np.arange(len(self.surface.vertices))
        rows, parts = [], []
        for vertices, k in zip(skins, frames, strict=True):
            found = self.surface.inside(vertices, self.samples[close[k]])
            place = vertices[whole[found.vertex]]
            depth = found.depth + CLEARANCE - self.give[close[k][found.index]] - self._yields[found.vertex]
            rows.append(np.full(len(depth), k))
            parts.append((found.vertex, place, found.out, depth))
        row = np.concatenate(rows)
        if not len(row):
            return None
        vertex, place, out, depth = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        tensor = lambda a: torch.tensor(np.asarray(a), dtype=torch.float32)
        return Pierced(
            torch.as_tensor(row),
            torch.as_tensor(vertex),
            tensor(place),
            tensor(out),
            tensor(depth),
            self.skin,
        )


def _joints(motion: Motion, body: Human) -> np.ndarray:
    """Return the joints (T, 55, 3) of a body in a motion, metres."""
    return forward_kinematics(motion.root, complete(motion.rotations), body.joints)[0]
