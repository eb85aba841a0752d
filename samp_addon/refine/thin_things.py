"""Thin things that pass through a body: samples of the scene's surface, pushed to the nearest skin. Imports torch.

Solids push vertices out (field.py); a seat of one sheet, a slat or a wire has no inside, and vertices pass it unseen.
The nearest skin of a sample deep in a thigh can be the upper one: a seat under a seated body is pushed out downwards,
its back rest backwards.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
import torch
from scipy.spatial import cKDTree

from ..body import human
from ..body.hands import complete
from ..body.human import Human
from ..evaluation.skin_depth import Inside, SkinSurface, surface_of
from ..motion import Goal, Motion
from ..scene.distance.point_cells import PointCells
from ..scene.distance.surface_samples import samples_in_box
from ..scene.geometry import area_vectors, extent
from ..skeleton import INDEX, forward_kinematics
from .pose import Along, Skin

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

MOVED = 0.04
"""Metres by which some joint moves between two frames that are looked at."""

SPREAD = 3
"""Frames between two that are pushed while the body hardly moves."""

FAR = 0.06
"""Metres between skin and samples from which a frame is not looked at again."""

SEATED = (0.08, 0.30)
"""Metres under the pelvis joint between which a level surface is a seat."""

UNDER = 0.12
"""Metres from the vertical through the pelvis joint within which it is over a seat."""

LEVEL = 0.7
"""Vertical component of the normals of seats."""

DEEP, THICKEST = 0.015, 0.16
"""Metres of depth between which a seat is pushed out downwards, and a back rest backwards: through a body at most."""

BEHIND, BACK_REACH = 0.03, 0.8
"""Metres behind a seated pelvis' goal from which on steep surfaces are its back rest, and around it up to which."""

TRUNK = ("pelvis", "spine1", "spine2", "spine3")

UPRIGHT_VIEW = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
"""Coordinates of a point (3,) seen from above."""


@dataclass(frozen=True)
class Pierced:
    """Samples inside the body as last looked at.

    point, out: (N, 3) each, and the direction to the nearest skin. seat: (N,) flags of seats. depth: (N,) metres.
    weight: (N,) frames that the sampled one stands for. along: the nearest skin in the direction ``out``.
    """

    point: np.ndarray
    out: np.ndarray
    seat: np.ndarray
    depth: torch.Tensor
    weight: torch.Tensor
    along: Along

    def depth_at(self, transforms: torch.Tensor) -> torch.Tensor:
        """Return the depths (N,) under other transforms (3, 4, R, 55) of the joints, linear in the skin's place."""
        return self.depth + self.along.at(transforms)


class ThinThings:
    """Samples (N, 3) of the surfaces around one take, whose changes are small.

    level: (N,) flags of samples of level surfaces. give: (N,) metres by which their objects yield. goal: of a seated
    body, behind which steep surfaces are its back rest; None where there is none.
    """

    def __init__(
        self, samples: np.ndarray, level: np.ndarray, give: np.ndarray, body: Human, goal: Goal | None = None
    ) -> None:
        self.samples, self.level, self.give, self.body, self.goal = samples, level, give, body, goal
        self.surface: SkinSurface = surface_of(body)
        self.skin = Skin(body, np.arange(len(body.vertices)))
        self._cells = PointCells(samples)
        self._yields = np.where(body.vertices[:, 1] < body.floor + SOLE_THICKNESS, SOLE_GIVE, 0.0)
        self.carriers = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], axis=1)[:, 0]
        """Joint (V,) that carries most of each vertex."""
        self._carrying = np.isin(self.carriers, [INDEX[name] for name in ("pelvis", "left_hip", "right_hip")])
        self._trunk = np.isin(self.carriers, [INDEX[name] for name in TRUNK])
        behind = body.vertices[:, 2] < body.joints[self.carriers][:, 2]
        self._underside, self._back = self._carrying & behind, self._trunk & behind
        self._at = np.full(len(body.vertices), -1)  # of a body's vertex among those of the surface
        self._at[self.surface.vertices] = np.arange(len(self.surface.vertices))
        self._rows: np.ndarray | None = None
        self._stands_for = np.zeros(0)

    @classmethod
    def around(
        cls,
        motion: Motion,
        triangles: np.ndarray,
        give: np.ndarray,
        body: Human,
        floor: float | None,
        goal: Goal | None = None,
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
        if not len(samples):
            return None
        used, back = np.unique(owners, return_inverse=True)
        normal = area_vectors(triangles[used])
        level = np.abs(normal[:, 1]) > LEVEL * np.linalg.norm(normal, axis=-1)
        return cls(samples, level[back], give[owners], body, goal)

    def afresh(self) -> ThinThings:
        """Return the same surfaces for other frames."""
        other = copy.copy(self)
        other._rows, other._stands_for = None, np.zeros(0)
        return other

    def deepest(self, motion: Motion) -> float:
        """Return the largest depth of a sample in the body, metres; 0 where the body is free."""
        found = self._found(motion, np.arange(len(motion)))
        return max([0.0, *(float(one.nearest.max(initial=0.0)) - CLEARANCE for one in found.values())])

    def seats(self, motion: Motion) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the samples of seats inside thighs and pelvis in all frames of a motion.

        Frames (N,), vertices (N,) of the nearest skin, the samples (N, 3) and their depths (N,), metres.
        """
        found = self._found(motion, np.arange(len(motion)))
        row = np.concatenate([np.zeros(0, int), *(np.full(one.seat.sum(), k) for k, one in found.items())])
        parts = [(one.vertex[one.seat], one.point[one.seat], one.depth[one.seat]) for one in found.values()]
        empty = np.zeros(0, int), np.zeros((0, 3)), np.zeros(0)
        return row, *(np.concatenate(arrays) for arrays in zip(empty, *parts, strict=True))

    def pierced(self, motion: Motion) -> Pierced | None:
        """Return the samples inside the body in the frames of a motion; None where there are none.

        Frames between which the body hardly moves stand for each other; those that are far from all samples in the
        first call are left out of later ones.
        """
        if self._rows is None:
            self._rows = _apart(_joints(motion, self.body))
            self._stands_for = np.diff(np.append(self._rows, len(motion)))
        found = self._found(motion, self._rows)
        used = np.array([int(k) in found for k in self._rows], bool)
        self._rows, self._stands_for = self._rows[used], self._stands_for[used]
        looked_at, rows, weight = _spread(self._rows, self._stands_for)
        count = [len(found[int(k)].depth) for k in looked_at]
        if not sum(count):
            return None
        joined = lambda name: np.concatenate([getattr(found[int(k)], name) for k in looked_at])
        tensor = lambda a: torch.tensor(np.asarray(a), dtype=torch.float32)
        out = joined("out")
        along = self.skin.along(motion, np.repeat(rows, count), joined("vertex"), out)
        # The nearest skin was found in the frame that was looked at, a little away from where it is in the pushed one.
        depth = joined("depth") + along.start - (joined("place") * out).sum(-1)
        weight = tensor(np.repeat(weight, count))
        return Pierced(joined("point"), out, joined("seat"), tensor(depth), weight, along)

    def _found(self, motion: Motion, rows: np.ndarray) -> dict[int, _Found]:
        """Return the samples inside the body for each of some frames in which any is near."""
        joints = _joints(motion, self.body)
        close = {int(k): self.surface.near(joints[k], self.samples, self._cells) for k in rows}
        close = {k: near for k, near in close.items() if len(near)}
        if not close:
            return {}
        skins = human.skin(self.body, motion.pose_slice(np.array(list(close))), self.surface.vertices)
        found = {}
        for (k, near), skin in zip(close.items(), skins.astype(np.float64), strict=True):
            inside = self.surface.inside(skin, self.samples[near], joints[k])
            if len(inside.depth) or inside.clearance < FAR:
                found[k] = self._of(inside, near, skin, joints[k, 0])
        return found

    def _of(self, inside: Inside, near: np.ndarray, skin: np.ndarray, pelvis: np.ndarray) -> _Found:
        """Return samples inside the skin (V, 3), the seats under a seated body to be pushed out downwards.

        near: indices of the samples that were looked at. pelvis: (3,) joint.
        """
        index = near[inside.index]
        point, vertex = self.samples[index], inside.vertex.copy()
        out, depth = inside.out.copy(), inside.depth.copy()
        seated = self._is_over_seat(near, pelvis)
        seat = seated & self._carrying[vertex] & self._are_seats(index, pelvis)
        pushed = [(seat, self._underside, np.array([0.0, -1.0, 0.0]))]
        if seated and self.goal is not None:
            pushed.append((self._trunk[vertex] & self._are_backs(index), self._back, -self.goal.direction))
        for rows, skin_side, axis in pushed:
            deep = np.flatnonzero(rows & (depth > DEEP))
            if not len(deep):
                continue
            own = np.flatnonzero(skin_side[self.surface.vertices])
            beside = (
                np.stack([[axis[2], 0.0, -axis[0]], [0.0, 1.0, 0.0]], -1) if axis[1] == 0 else UPRIGHT_VIEW
            )
            nearest = own[cKDTree(skin[own] @ beside).query(point[deep] @ beside)[1]]
            along = (skin[nearest] - point[deep]) @ axis
            deeper = (along > depth[deep]) & (along < THICKEST)
            deep, nearest, along = deep[deeper], nearest[deeper], along[deeper]
            vertex[deep], depth[deep], out[deep] = self.surface.vertices[nearest], along, axis
        place = skin[self._at[vertex]]
        allowed = CLEARANCE - self.give[index]
        nearest_depth = inside.depth + allowed - self._yields[inside.vertex]
        return _Found(vertex, place, out, depth + allowed - self._yields[vertex], point, seat, nearest_depth)

    def _are_seats(self, index: np.ndarray, pelvis: np.ndarray) -> np.ndarray:
        """Return flags (N,) of samples of level surfaces at the height of a seat under a pelvis joint (3,)."""
        below = pelvis[1] - self.samples[index, 1]
        return self.level[index] & (below > SEATED[0]) & (below < SEATED[1])

    def _are_backs(self, index: np.ndarray) -> np.ndarray:
        """Return flags (N,) of samples of steep surfaces behind the goal of a seated body."""
        away = self.samples[index] - self.goal.position
        behind = away @ self.goal.direction < -BEHIND
        return (
            ~self.level[index] & behind & (away[:, 1] > -SEATED[0]) & (np.square(away).sum(1) < BACK_REACH**2)
        )

    def _is_over_seat(self, near: np.ndarray, pelvis: np.ndarray) -> bool:
        """Return whether a seat is under the pelvis joint (3,)."""
        away = self.samples[near][:, [0, 2]] - pelvis[[0, 2]]
        return bool((self._are_seats(near, pelvis) & (np.square(away).sum(1) < UNDER**2)).any())


@dataclass(frozen=True)
class _Found:
    """Samples inside the body in one frame.

    vertex: (N,) of the nearest skin. place, out: (N, 3) where it is, and the direction to it. depth: (N,) metres.
    point: (N, 3) the samples. seat: (N,) flags of seats under the body. nearest: (N,) depths to the nearest skin.
    """

    vertex: np.ndarray
    place: np.ndarray
    out: np.ndarray
    depth: np.ndarray
    point: np.ndarray
    seat: np.ndarray
    nearest: np.ndarray


def _apart(joints: np.ndarray) -> np.ndarray:
    """Return the first frame, and those in which some joint (T, J, 3) has moved since the last one returned."""
    rows = [0]
    for k in range(1, len(joints)):
        if np.abs(joints[k] - joints[rows[-1]]).max() > MOVED:
            rows.append(k)
    return np.array(rows)


def _spread(rows: np.ndarray, stands_for: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Spread frames (N,) over those that they stand for (N,): else a long hold would be pushed in one frame only.

    Return which frame was looked at, the frame that is pushed, and its weight, each (M,).
    """
    looked_at, pushed, weight = [], [], []
    for row, count in zip(rows, stands_for, strict=True):
        own = np.arange(row, row + max(int(count), 1), SPREAD)
        looked_at.append(np.full(len(own), row))
        pushed.append(own)
        weight.append(np.full(len(own), count / len(own)))
    return tuple(np.concatenate([np.zeros(0, int), *parts]) for parts in (looked_at, pushed, weight))


def _joints(motion: Motion, body: Human) -> np.ndarray:
    """Return the joints (T, 55, 3) of a body in a motion, metres."""
    return forward_kinematics(motion.root, complete(motion.rotations), body.joints)[0]
