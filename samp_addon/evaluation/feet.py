"""Foot sliding: the measure of Zhang et al. 2018 (mode-adaptive networks), the slide during stances, and gliding.

The sole patch of a foot is the skin under it. Its speed is that of its centroid, its height over the floor that of its
lowest vertex. Network frame, metres.
"""

from __future__ import annotations

import functools

import numpy as np
from scipy import ndimage

from ..body import human
from ..motion import Motion, velocities
from ..skeleton import INDEX

SLIDE_HEIGHT = 2.5
"""Centimetres: H of the foot slide. A foot above it does not count."""

STANCE_HEIGHT, STANCE_SPEED = 1.5, 15.0
"""Centimetres, and centimetres per second: upper limits during a stance."""

STANCE_SECONDS = 5 / 30
SOLE_THICKNESS = 0.015
"""Metres over the lowest vertex of the rest pose up to which skin belongs to the sole."""

GLIDING = 0.2
"""Metres per second of the slower ball of the two feet above which a body on its feet glides. In captured walks one
foot is nearly always slower."""
GLIDE_SECONDS = 1 / 3
"""Shortest glide. While the weight passes from one foot to the other, both move for a few frames."""
RUNNING = 1.6
"""Metres per second of the pelvis from which both feet may be in the air."""
ON_FEET = 0.75
"""Metres of the pelvis over the lower ball of the foot, above which a body is on its feet."""


@functools.cache
def sole_patches() -> tuple[np.ndarray, np.ndarray]:
    """Return the vertex indices of the left and of the right sole of the default human."""
    body = human.load()
    main = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], axis=1)[:, 0]
    low = body.vertices[:, 1] < body.floor + SOLE_THICKNESS
    patches = []
    for side in ("left", "right"):
        patches.append(np.flatnonzero(low & np.isin(main, [INDEX[f"{side}_ankle"], INDEX[f"{side}_foot"]])))
    return patches[0], patches[1]


def sole_tracks(
    motion: Motion, floor: float = 0.0, body: human.Human | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Track the sole patches of both feet.

    Returns, (T, 2) each, their horizontal speed in cm/s and the heights of their lowest vertex and of their centroid
    over the floor in cm. floor: height of the floor, metres. body: the default human if left out.
    """
    speeds, lowest, centroid = [], [], []
    left, right = sole_patches()
    both = human.skin(body or human.load(), motion, np.concatenate([left, right])).astype(np.float64)
    for vertices in (both[:, : len(left)], both[:, len(left) :]):
        centre = vertices.mean(1)
        speeds.append(np.linalg.norm(velocities(centre[:, [0, 2]], motion.fps), axis=-1) * 100)
        lowest.append((vertices[..., 1].min(1) - floor) * 100)
        centroid.append((centre[:, 1] - floor) * 100)
    return np.stack(speeds, -1), np.stack(lowest, -1), np.stack(centroid, -1)


def foot_slide(speed: np.ndarray, height: np.ndarray) -> float:
    """Return the mean of v (2 - 2^(h / H)) over frames and feet, cm/s; v: (T, 2) cm/s, h: (T, 2) cm, H = 2.5 cm."""
    share = 2 - 2 ** (np.clip(height, 0, SLIDE_HEIGHT) / SLIDE_HEIGHT)
    return float((speed * share).mean())


def stances(speed: np.ndarray, height: np.ndarray, fps: float) -> np.ndarray:
    """Flag frames (T, 2) in a stance: the sole patch within 1.5 cm of its support, slower than 15 cm/s, for 1/6 s."""
    still = (np.abs(height) <= STANCE_HEIGHT) & (speed < STANCE_SPEED)
    least = max(int(round(STANCE_SECONDS * fps)), 1)
    result = np.zeros_like(still)
    for foot in range(still.shape[1]):
        runs, count = ndimage.label(still[:, foot])
        length = np.bincount(runs, minlength=count + 1)
        length[0] = 0
        result[:, foot] = length[runs] >= least
    return result


def smoothed_speeds(points: np.ndarray, fps: float, window: int = 5) -> np.ndarray:
    """Return the speeds (T, ...) of points (T, ..., D), m/s, averaged over ``window`` frames."""
    speed = np.linalg.norm(velocities(points, fps), axis=-1)
    return ndimage.uniform_filter1d(speed, window, axis=0, mode="nearest")


def glides(motion: Motion) -> list[tuple[int, int]]:
    """Return the runs (first, last + 1) of frames in which a body on its feet moves with both of them at once."""
    if len(motion) < 2:
        return []
    balls = motion.forward_kinematics()[0][:, [INDEX["left_foot"], INDEX["right_foot"]]]
    slower = smoothed_speeds(balls[..., [0, 2]], motion.fps).min(1)
    pace = np.linalg.norm(velocities(motion.root[:, [0, 2]], motion.fps), axis=-1)
    upright = motion.root[:, 1] - balls[..., 1].min(1) > ON_FEET
    runs, _ = ndimage.label((slower > GLIDING) & (pace < RUNNING) & upright)
    found = [(int(run.start), int(run.stop)) for (run,) in ndimage.find_objects(runs)]
    return [(first, last) for first, last in found if last - first >= GLIDE_SECONDS * motion.fps]


def measures(motion: Motion, floor: float = 0.0, body: human.Human | None = None) -> dict[str, float | None]:
    """Compute the metrics of the feet; arguments as for `sole_tracks`.

    These are foot slide (cm/s), mean speed in stances (cm/s; None without one), share of time in stance, time of
    gliding (s), and depth of the feet below the floor (cm).
    """
    speed, lowest, centroid = sole_tracks(motion, floor, body)
    # The patch is up to 1.5 cm thick: the height of its centroid is relative to that of a flat foot.
    standing = stances(speed, centroid - _flat_centroid(), motion.fps)
    return {
        "foot_slide_cm_s": foot_slide(speed, lowest),
        "stance_slide_cm_s": float(speed[standing].mean()) if standing.any() else None,
        "stance_share": float(standing.mean()),
        "glide_s": sum(last - first for first, last in glides(motion)) / motion.fps,
        "foot_depth_cm": float(max(-lowest.min(), 0.0)),
    }


@functools.cache
def _flat_centroid() -> float:
    """Return the height of the sole's centroid over its lowest vertex in the rest pose, cm."""
    body = human.load()
    heights = [body.vertices[patch, 1].mean() - body.vertices[patch, 1].min() for patch in sole_patches()]
    return float(np.mean(heights) * 100)
