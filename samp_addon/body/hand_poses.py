"""The pose of both hands as 24 numbers, 12 principal components each, in the place of SMPL-X's hand pose.

Nobody was captured with fingers: the set of hands whose components these are is synthetic. It holds relaxed hands,
fists, and flat hands as they lie on surfaces.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from .. import rotation
from .hands import complete, relaxed_hands

EACH = 12
COUNT = 2 * EACH
KINDS = ("relaxed", "fist", "flat")
_HANDS = 600
_FINGERS, _JOINTS = 5, 3
_MIRROR = np.array([1.0, -1.0, -1.0])
_FIST = np.radians(78.0)
_RIGHT = slice(18, 33)  # of the right hand among the joints from 22 on
_FIRST = 25  # of the joints of both hands, behind the face's


@dataclass(frozen=True)
class HandSpace:
    """mean: (45,) rotation vectors of the right hand. components: (12, 45), one standard deviation each. kinds: name ->
    (12,) of a typical hand."""

    mean: np.ndarray
    components: np.ndarray
    kinds: dict[str, np.ndarray]


@functools.cache
def space() -> HandSpace:
    """Return mean and components of the synthetic hands; the same in every run."""
    rng = np.random.default_rng(11)
    typical = {kind: _hand(kind, np.ones(_FINGERS), np.zeros((_FINGERS, _JOINTS, 3))) for kind in KINDS}
    hands = []
    for number in range(_HANDS):
        kind = KINDS[(0, 0, 1, 2)[number % 4]]
        curls = np.clip(rng.normal(1, 0.25) + rng.normal(0, 0.15, _FINGERS), 0.1, 1.6)
        hands.append(_hand(kind, curls, rng.normal(0, 0.04, (_FINGERS, _JOINTS, 3))))
    hands = np.array(hands)
    mean = hands.mean(0)
    _, sizes, axes = np.linalg.svd(hands - mean, full_matrices=False)
    components = axes[:EACH] * sizes[:EACH, None] / np.sqrt(_HANDS)
    codes = lambda hand: (hand - mean) @ np.linalg.pinv(components)
    return HandSpace(mean, components, {kind: codes(hand) for kind, hand in typical.items()})


def _hand(kind: str, curls: np.ndarray, wobble: np.ndarray) -> np.ndarray:
    """Return rotation vectors (45,) of a right hand. curls: factor of each finger. wobble: (5, 3, 3) radians."""
    relaxed = rotation.to_axis_angle(relaxed_hands()[_RIGHT]).reshape(_FINGERS, _JOINTS, 3)
    made = relaxed.copy()
    if kind == "fist":
        made[:4] = 0
        made[:4, :, 2] = _FIST
        made[4] = 1.6 * relaxed[4]
    elif kind == "flat":
        made = 0.2 * relaxed
    scaled = made * curls[:, None, None] if kind != "fist" else made * np.clip(curls, 0.7, 1.1)[:, None, None]
    return (scaled + wobble).reshape(-1)


def code(kind: str) -> np.ndarray:
    """Return the numbers (24,) of both hands of a kind."""
    return np.tile(space().kinds[kind], 2)


def rotations(codes: np.ndarray) -> np.ndarray:
    """Return local quaternions (..., 30, 4) of the left and the right hand's joints, of codes (..., 24)."""
    hands = np.asarray(codes).reshape(*codes.shape[:-1], 2, EACH) @ space().components + space().mean
    vectors = hands.reshape(*codes.shape[:-1], 2, _FINGERS * _JOINTS, 3)
    left = vectors[..., :1, :, :] * _MIRROR  # the code of the left hand is that of its mirror image
    both = np.concatenate([left, vectors[..., 1:, :, :]], axis=-3)
    return rotation.from_axis_angle(both.reshape(*codes.shape[:-1], 2 * _FINGERS * _JOINTS, 3))


def codes(quats: np.ndarray) -> np.ndarray:
    """Return the numbers (..., 24) that are nearest to local quaternions (..., 30, 4): the inverse of `rotations`."""
    vectors = rotation.to_axis_angle(np.asarray(quats)).reshape(*quats.shape[:-2], 2, _FINGERS * _JOINTS, 3)
    vectors = np.concatenate([vectors[..., :1, :, :] * _MIRROR, vectors[..., 1:, :, :]], axis=-3)
    hands = vectors.reshape(*quats.shape[:-2], 2, 3 * _FINGERS * _JOINTS) - space().mean
    return (hands @ np.linalg.pinv(space().components)).reshape(*quats.shape[:-2], COUNT)


def with_hands(turns: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return local quaternions (T, 55, 4) of a body's joints (T, 22, 4) with hands (T, 24)."""
    return np.concatenate([complete(turns)[:, :_FIRST], rotations(numbers)], axis=1)


def read_hands(turns: np.ndarray) -> np.ndarray:
    """Return the numbers (T, 24) of the hands of local quaternions (T, J, 4); relaxed ones where J is 22."""
    return codes(complete(turns)[:, _FIRST:])
