"""Solve labelled markers for a moving skeleton of the subject's own size.

Poses and sizes are solved alternately: poses of the figure, then its bone lengths and the positions of the markers on
its bones by linear least squares. Both start from the default human, scaled by stature.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ....samp_addon import rotation, skeleton
from ....samp_addon.errors import SampError
from ....samp_addon.refine.runs import runs
from ..formats import c3d_file
from ..recording import Recording
from . import places as table
from .figure import COUNT, Figure, of_default, rest_of, sized
from .pose import Poses, kinematics, posed

FPS = 30.0
SEEN = 0.6  # least share of visible markers in a frame
FITTED = 160  # frames from which a subject's size is estimated
ROUNDS, STEPS = 6, 15  # alternations of poses and sizes, and descent steps in each
WORST = 0.03  # metres, root mean square: solutions with a larger error are rejected
FEWEST = 20  # frames of the shortest recording
KEEP_LENGTH, KEEP_PLACE = (0.02, 0.002), (0.02, 0.005)  # weight of the previous values, first and last round


def solved(paths: Sequence[Path]) -> list[Recording]:
    """Return the recordings of one subject's .c3d files, on one skeleton, at 30 frames a second.

    Raise SampError where files cannot be read, or too few of their markers are known.
    """
    files = [c3d_file.read(path) for path in paths]
    columns = table.known(files[0].names)
    for one in files[1:]:
        columns = {name: k for name, k in columns.items() if name in table.known(one.names)}
    if len(columns) < c3d_file.FEWEST:
        raise SampError(
            f"'{files[0].name}' has {len(columns)} known markers; a body needs at least {c3d_file.FEWEST}."
        )
    names = list(columns)
    tracks = [_upright(_resampled(one, names), names) for one in files]
    pairs = [(one.name, track) for one, track in zip(files, tracks, strict=True) if len(track) >= FEWEST]
    if not pairs:
        raise SampError(f"'{files[0].name}' has too few visible markers per frame.")
    figure = fitted(np.concatenate([track for _, track in pairs]), names)
    found = []
    for name, track in pairs:
        poses = posed(track, figure)
        if np.median(poses.error) < WORST:
            found.append(_recording(name, poses, figure))
    if not found:
        raise SampError(f"The markers of '{files[0].name}' do not fit a body.")
    return found


def _resampled(one: c3d_file.Markers, names: Sequence[str]) -> np.ndarray:
    """Return positions (T, M, 3) at 30 frames a second, means of three frames, of the longest well-seen run."""
    columns = table.known(one.names)
    places = one.places[:, [columns[name] for name in names]]
    at = np.arange(0, len(places) - 1 + 1e-6, one.fps / FPS)
    near = np.clip(np.round(at).astype(int)[:, None] + [-1, 0, 1], 0, len(places) - 1)
    window = places[near] if one.fps > 2 * FPS else places[near[:, 1:2]]
    seen = np.isfinite(window)
    mean = np.where(seen, window, 0.0).sum(1) / np.maximum(seen.sum(1), 1)
    places = np.where(seen.any(1), mean, np.nan)
    stretches = runs(np.isfinite(places[..., 0]).mean(1) > SEEN, 8, 3)
    start, stop = max(stretches, key=lambda stretch: stretch[1] - stretch[0], default=(0, 0))
    return places[start:stop]


def _upright(places: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Return the positions with Y up; up is the axis along which the head is over the feet in most frames."""
    if not len(places):
        return places
    mean = lambda *ends: np.nanmean(
        np.stack([places[:, k] for k, name in enumerate(names) if name.endswith(ends)], 1), axis=1
    )
    up = int(np.argmax(np.nanmean(mean("FHD", "SHO", "C7", "CLAV") - mean("HEE", "TOE", "ANK"), axis=0)))
    return places[..., {0: [1, 0, 2], 1: [0, 1, 2], 2: [0, 2, 1]}[up]] * (
        np.array([1.0, 1.0, 1.0]) if up == 1 else np.array([1.0, 1.0, -1.0])
    )


def fitted(places: np.ndarray, names: Sequence[str]) -> Figure:
    """Return the figure that fits marker positions (T, M, 3), metres, from frames spread over them."""
    frames = places[np.unique(np.linspace(0, len(places) - 1, FITTED).astype(int))]
    figure = of_default(frames, names)
    for k in range(ROUNDS):
        poses = posed(frames, figure, STEPS)
        along = k / max(ROUNDS - 1, 1)
        keep = [first * (last / first) ** along for first, last in (KEEP_LENGTH, KEEP_PLACE)]
        _, axes, _ = kinematics(poses.root, poses.turns, figure)
        figure = sized(frames, poses.root, axes, figure, *keep)
    return figure


def _recording(name: str, poses: Poses, figure: Figure) -> Recording:
    """Return the poses as a recording on SMPL-X's joints, smoothed, because each frame was solved independently."""
    turns = rotation.continuous(rotation.from_axis_angle(poses.turns))
    turns = rotation.normalise(gaussian_filter1d(turns, 0.8, axis=0, mode="nearest"))
    root = gaussian_filter1d(poses.root, 0.8, axis=0, mode="nearest")
    joints, axes, _ = kinematics(root, rotation.to_axis_angle(turns), figure)
    rest = rest_of(figure.offsets)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (COUNT, 1))
    return Recording(
        name, FPS, skeleton.BODY_JOINTS, skeleton.PARENTS[:COUNT], rest, rest, joints,
        rotation.matrix_to_quaternion(axes), still,
    )  # fmt: skip
