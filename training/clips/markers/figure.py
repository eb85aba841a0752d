"""A subject as a skeleton with markers, and the sizes that fit its poses best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....samp_addon import skeleton
from . import places as table

COUNT = skeleton.BODY_COUNT


@dataclass(frozen=True, eq=False)
class Figure:
    """A subject's sizes, in metres and in the axes of SMPL-X's rest pose.

    offsets: (22, 3) of the joints from their parents. joints: (M,) indices to which the markers belong. places: (M, 3)
    offsets of the markers from those joints.
    """

    offsets: np.ndarray
    joints: np.ndarray
    places: np.ndarray


def of_default(places: np.ndarray, names: Sequence[str]) -> Figure:
    """Return the default human with the markers, scaled to the stature of positions (T, M, 3), metres, Y up."""
    known = table.places()
    rest = skeleton.default_rest_joints()[:COUNT]
    joints = np.array([known[name][0] for name in names])
    own = np.array([known[name][1] for name in names])
    size = _stature(places, names) / _stature((rest[joints] + own)[None], names)
    return Figure((rest - rest[np.maximum(skeleton.PARENTS[:COUNT], 0)]) * size, joints, own * size)


def _stature(places: np.ndarray, names: Sequence[str]) -> float:
    """Return the height of the shoulders over the feet, metres, in the most upright frames."""
    mean = lambda *ends: np.nanmean(
        [places[:, k, 1] for k, name in enumerate(names) if name.endswith(ends)], axis=0
    )
    return float(np.nanpercentile(mean("SHO", "C7", "CLAV") - mean("HEE", "TOE", "ANK"), 95))


def rest_of(offsets: np.ndarray) -> np.ndarray:
    """Return joint positions (22, 3) from offsets (22, 3) to their parents."""
    rest = np.zeros((COUNT, 3))
    for j in range(1, COUNT):
        rest[j] = rest[skeleton.PARENTS[j]] + offsets[j]
    return rest


def sized(
    places: np.ndarray,
    root: np.ndarray,
    axes: np.ndarray,
    figure: Figure,
    keep_length: float,
    keep_place: float,
) -> Figure:
    """Return the figure with the lengths and marker positions that fit best, regularised towards the previous ones.

    places: (T, M, 3) of the markers, metres, NaN where occluded. root: (T, 3). axes: (T, 22, 3, 3) of the joints.
    keep_length, keep_place: weights of the previous values against the mean over frames. Bone lengths are symmetrised.
    """
    seen = np.isfinite(places[..., 0])
    markers, lengths = len(figure.joints), 3 * COUNT
    size = lengths + 3 * markers
    normal, right = np.zeros((size, size)), np.zeros(size)
    for m, joint in enumerate(figure.joints):
        frames = np.flatnonzero(seen[:, m])
        rows = np.zeros((len(frames), 3, size))
        rows[:, :, lengths + 3 * m : lengths + 3 * m + 3] = axes[frames, joint]
        j = joint
        while j > 0:
            rows[:, :, 3 * j : 3 * j + 3] = axes[frames, skeleton.PARENTS[j]]
            j = skeleton.PARENTS[j]
        rows = rows.reshape(-1, size)
        normal += rows.T @ rows / len(places)
        right += rows.T @ (places[frames, m] - root[frames]).ravel() / len(places)
    keep = np.concatenate([np.full(lengths, keep_length), np.full(size - lengths, keep_place)])
    before = np.concatenate([figure.offsets.ravel(), figure.places.ravel()])
    found = np.linalg.solve(normal + np.diag(keep + 1e-6), right + keep * before)
    offsets = found[:lengths].reshape(COUNT, 3)
    for j, twin in enumerate(skeleton.mirror_joints()):
        if j < twin:
            offsets[j] = (offsets[j] + offsets[twin] * table.MIRROR) / 2
            offsets[twin] = offsets[j] * table.MIRROR
        elif j == twin:
            offsets[j, 0] = 0.0
    return Figure(offsets, figure.joints, found[lengths:].reshape(markers, 3))
