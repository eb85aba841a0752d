"""Fit poses of a figure to marker positions: Levenberg-Marquardt, all frames at once.

Errors are weighted robustly, and weak priors restrain improbable joint rotations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....samp_addon import rotation, skeleton
from .figure import COUNT, Figure, rest_of

ROBUST = 0.05  # metres of error from which a marker's weight decreases
# Joints that share one rotation in equal parts; the spine has too few markers for three rotations.
GROUPS = (("pelvis",), ("spine1", "spine2", "spine3"), ("neck", "head")) + tuple(
    (f"{side}_{part}",)
    for part in ("collar", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
    for side in ("left", "right")
)
ENOUGH, GIVEN_UP = 1e-3, 1e3  # relative gain of a step, and damping, at which a frame stops
LONGEST = 0.6  # largest change in a step, metres and radians
SOFT = (0.004, 0.004, 0.004)  # as STIFF, for joints that are not listed there
# Marker error, metres, whose cost equals that of a radian of a joint's rotation about x, y, z.
STIFF = {"pelvis": (0.0, 0.0, 0.0), "spine1": (0.02, 0.02, 0.02), "neck": (0.03, 0.03, 0.03),
         "collar": (0.12, 0.12, 0.12), "elbow": (0.02, 0.0, 0.08), "wrist": (0.06, 0.06, 0.06),
         "knee": (0.0, 0.10, 0.10), "ankle": (0.02, 0.02, 0.02)}  # fmt: skip
HANG = {"left_shoulder": (0, 0, -1.2), "right_shoulder": (0, 0, 1.2), "left_elbow": (0, -0.3, 0),
        "right_elbow": (0, 0.3, 0), "left_knee": (0.2, 0, 0), "right_knee": (0.2, 0, 0)}  # fmt: skip
"""Initial rotation vectors: arms down, limbs slightly bent."""


@dataclass(frozen=True, eq=False)
class Poses:
    """root: (T, 3) metres. turns: (T, G, 3) rotation vectors of the groups. error: (T,) metres, root mean square."""

    root: np.ndarray
    turns: np.ndarray
    error: np.ndarray

    def part(self, frames: np.ndarray | slice) -> Poses:
        """Return a selection of the frames."""
        return Poses(self.root[frames], self.turns[frames], self.error[frames])


def posed(places: np.ndarray, figure: Figure, steps: int = 25) -> Poses:
    """Return the poses of a figure in which the markers are nearest to positions (T, M, 3), metres, Y up."""
    waist = np.flatnonzero(figure.joints == 0)
    rest = figure.places[waist]
    root = np.zeros((len(places), 3))
    turns = np.zeros((len(places), len(GROUPS), 3))
    for k, group in enumerate(GROUPS):
        turns[:, k] = HANG.get(group[0], (0, 0, 0))
    for t, frame in enumerate(places):
        seen = np.isfinite(frame[waist, 0])
        if seen.sum() < 3:
            root[t], turns[t, 0] = (
                (root[t - 1], turns[t - 1, 0]) if t else (np.nanmean(frame, 0), turns[t, 0])
            )
            continue
        turn = _aligned(rest[seen], frame[waist][seen])
        turns[t, 0] = rotation.to_axis_angle(rotation.matrix_to_quaternion(turn))
        root[t] = frame[waist][seen].mean(0) - turn @ rest[seen].mean(0)
    poses = _descended(places, figure, Poses(root, turns, np.full(len(places), np.inf)), steps)
    for _ in range(2):  # restart frames with a large error from the nearest good one
        bad = poses.error > 1.5 * np.median(poses.error) + 0.003
        if bad.all() or not bad.any():
            break
        good = np.flatnonzero(~bad)
        again = np.flatnonzero(bad)
        near = good[np.abs(good[None] - again[:, None]).argmin(1)]
        initial = replace(poses.part(near), root=poses.root[near] + root[again] - root[near])
        retried = _descended(places[again], figure, initial, steps)
        better = retried.error < poses.error[again]
        poses.root[again[better]] = retried.root[better]
        poses.turns[again[better]] = retried.turns[better]
        poses.error[again[better]] = retried.error[better]
    return poses


def _aligned(rest: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) that turns points (N, 3) about their centroid onto others, least squares."""
    u, _, v = np.linalg.svd((rest - rest.mean(0)).T @ (seen - seen.mean(0)))
    return v.T @ np.diag([1.0, 1.0, np.linalg.det(v.T @ u.T)]) @ u.T


def kinematics(root: np.ndarray, turns: np.ndarray, figure: Figure) -> tuple[np.ndarray, ...]:
    """Return the joints (T, 22, 3), their axes (T, 22, 3, 3) and the markers (T, M, 3), metres."""
    local = np.tile([1.0, 0.0, 0.0, 0.0], (len(root), COUNT, 1))
    for k, group in enumerate(GROUPS):
        part = rotation.from_axis_angle(turns[:, k] / len(group))
        for name in group:
            local[:, skeleton.INDEX[name]] = part
    joints, globals_ = skeleton.forward_kinematics(root, local, rest_of(figure.offsets))
    axes = rotation.quaternion_to_matrix(globals_)
    placed = joints[:, figure.joints] + np.einsum("tmab,mb->tma", axes[:, figure.joints], figure.places)
    return joints, axes, placed


def _below(figure: Figure) -> np.ndarray:
    """Flag the markers (22, M) that each joint moves."""
    moved = np.zeros((COUNT, len(figure.joints)), bool)
    for m, joint in enumerate(figure.joints):
        j = joint
        while j >= 0:
            moved[j, m] = True
            j = skeleton.PARENTS[j]
    return moved


class _Fit:
    """The errors of poses against marker positions (T, M, 3), NaN where occluded."""

    def __init__(self, places: np.ndarray, figure: Figure) -> None:
        self.figure = figure
        self.seen = np.isfinite(places[..., 0])
        self.places = np.where(self.seen[..., None], places, 0.0)
        stiff = [STIFF.get(group[0].split("_")[-1], SOFT) for group in GROUPS]
        self.prior = np.concatenate([np.zeros(3), *stiff]) ** 2
        self.below = _below(figure)

    def part(self, frames: np.ndarray) -> _Fit:
        """Return the fit of a selection of the frames."""
        other = object.__new__(_Fit)
        other.__dict__.update(self.__dict__, seen=self.seen[frames], places=self.places[frames])
        return other

    def errors(self, root: np.ndarray, turns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the markers' errors (T, M, 3), metres, their weights (T, M, 1), and the cost (T,) of the poses."""
        off = (kinematics(root, turns, self.figure)[2] - self.places) * self.seen[..., None]
        weight = 1 / np.sqrt(1 + (np.linalg.norm(off, axis=-1, keepdims=True) / ROBUST) ** 2)
        held = (self.prior[3:] * turns.reshape(len(root), -1) ** 2).sum(1)
        return off, weight, (weight * off**2).sum((1, 2)) + held

    def step(self, root: np.ndarray, turns: np.ndarray, damping: np.ndarray) -> np.ndarray:
        """Return the step (T, 3 + 3 G) of root and turns, each turn about its own axes, for damping (T,)."""
        joints, axes, placed = kinematics(root, turns, self.figure)
        off, weight, _ = self.errors(root, turns)
        count, size = len(root), len(self.prior)
        slopes = np.zeros((count, len(self.figure.joints), 3, size))
        slopes[..., :3] = np.eye(3)
        for k, group in enumerate(GROUPS):
            for name in group:
                j = skeleton.INDEX[name]
                m = np.flatnonzero(self.below[j])
                # A rotation about axis a of the joint moves a marker by a x arm.
                moved = -_cross_matrices(placed[:, m] - joints[:, j, None]) @ axes[:, j, None]
                slopes[:, m, :, 3 + 3 * k : 6 + 3 * k] += moved / len(group)
        scale = np.sqrt(weight) * self.seen[..., None]
        slopes = (slopes * scale[..., None]).reshape(count, -1, size)
        vector = np.concatenate([np.zeros((count, 3)), turns.reshape(count, -1)], 1)
        turned = np.swapaxes(slopes, 1, 2)
        normal = turned @ slopes + np.diag(self.prior + 1e-9)
        gradient = (turned @ (off * scale).reshape(count, -1, 1))[..., 0] + self.prior * vector
        trust = damping[:, None] * (np.einsum("naa->na", normal) + 1e-3)
        damped = normal + np.eye(size) * trust[:, None, :]
        return np.clip(np.linalg.solve(damped, -gradient[..., None])[..., 0], -LONGEST, LONGEST)


def _cross_matrices(vectors: np.ndarray) -> np.ndarray:
    """Return the matrices (..., 3, 3) whose product with a vector is the cross product with vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*x.shape, 3, 3)


def _descended(places: np.ndarray, figure: Figure, poses: Poses, steps: int) -> Poses:
    """Optimise root and turns of each frame by Levenberg-Marquardt, until no frame's cost decreases."""
    fit = _Fit(places, figure)
    root, turns = poses.root.copy(), poses.turns.copy()
    cost = fit.errors(root, turns)[2]
    damping = np.full(len(root), 1e-3)
    going = np.arange(len(root))
    for _ in range(steps):
        some = fit.part(going)
        step = some.step(root[going], turns[going], damping[going])
        turn = rotation.from_axis_angle(step[:, 3:].reshape(-1, len(GROUPS), 3))
        tried = rotation.to_axis_angle(rotation.multiply(rotation.from_axis_angle(turns[going]), turn))
        moved = root[going] + step[:, :3]
        new = some.errors(moved, tried)[2]
        gain = cost[going] - new
        good = gain > 0
        damping[going] *= np.where(good, 0.3, 5.0)
        better = going[good]
        root[better], turns[better], cost[better] = moved[good], tried[good], new[good]
        still = np.where(good, gain > ENOUGH * cost[going], damping[going] < GIVEN_UP)
        going = going[still]
        if not len(going):
            break
    away = np.linalg.norm(fit.errors(root, turns)[0], axis=-1)
    error = np.sqrt((away**2).sum(1) / np.maximum(fit.seen.sum(1), 1))
    return Poses(root, turns, error)
