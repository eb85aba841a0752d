"""What supports a body: squats in the air, flights, seats that glide, and feet that hang. Network frame, metres.

A take can end on its goal and still contain physically impossible motion. These measures look at every frame of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import numpy as np
from scipy.spatial import cKDTree

from ..body import human
from ..body.human import Human
from ..motion import Goal, Motion
from ..scene.geometry import in_box
from ..skeleton import INDEX
from ..vocabulary import ACTIONS
from .feet import sole_patches
from .obstacles import Obstacles

BENT = np.radians(50.0)
"""Flexion beyond which a knee counts as bent."""

UNDER = 0.06
"""Metres under hips and thighs within which something carries them."""

ASIDE = 0.008
"""Metres to the side of skin within which a sample is under it: half of the distance between samples."""

TOUCHED = 0.15
"""Seconds: a seat that is touched no longer does not carry a body that squats before and after."""

REACH = 0.03
"""Metres within which any skin is supported."""

NEAR = 0.036
"""Metres from a vertex of the skin, of which the nearest is up to 2 cm aside, to what is within REACH of the skin."""

RUNNING, JOGGING = 1.8, 1.3
"""Metres per second of the pelvis over the floor from which a body may be in the air, and where it is labelled as
running."""

STRIDE = 0.5
"""Seconds that no running stride is in the air."""

FALL_IN = 0.2
"""Seconds after sitting down and before standing up in which a seated pelvis may still move."""

HOLD = 1.0
"""Seconds at the end of a take in which the feet of a seated body rest on the floor."""

LOW_SEAT = 0.42
"""Metres over the floor below which the feet of a seated body reach it."""

CHUNK = 32
"""Frames whose surroundings are sampled together."""

NONE = {
    "air_squat_s": 0.0, "unsupported_s": 0.0, "seated_speed_m_s": None, "hanging_feet_cm": None,
}  # fmt: skip


@dataclass(frozen=True)
class Support:
    """Flags (T,) of a take: knees bent, hips or thighs carried, any part of the body supported; and heights (T,) of
    the lowest seat skin and of the lowest sole, metres."""

    bent: np.ndarray
    carried: np.ndarray
    supported: np.ndarray
    seat: np.ndarray
    sole: np.ndarray


def knee_flexion(motion: Motion) -> np.ndarray:
    """Return the flexion (T, 2) of the left and the right knee, radians; 0 for a straight leg."""
    joints = motion.forward_kinematics()[0]
    angles = []
    for side in ("left", "right"):
        hip, knee, ankle = (joints[:, INDEX[f"{side}_{name}"]] for name in ("hip", "knee", "ankle"))
        thigh, shin = knee - hip, ankle - knee
        length = np.linalg.norm(thigh, axis=-1) * np.linalg.norm(shin, axis=-1)
        angles.append(np.arccos(np.clip((thigh * shin).sum(-1) / np.maximum(length, 1e-9), -1, 1)))
    return np.stack(angles, -1)


def observe(
    motion: Motion,
    obstacles: Obstacles,
    floor: float,
    body: Human | None = None,
    found: tuple[np.ndarray, np.ndarray] | None = None,
    skin: np.ndarray | None = None,
) -> Support:
    """Return what supports the body in each frame. floor: height below which everything is solid, metres.

    found: result of collision.body_depth, if known. skin: collision vertices (T, 2048, 3), if known.
    """
    body = body or human.load()
    skin = (human.skin(body, motion, body.collision) if skin is None else skin).astype(np.float64)
    depth, touching = found or obstacles.depth(skin, floor)
    seat = seat_skin(body)
    bent = knee_flexion(motion).min(1) > BENT
    carried = (depth[:, seat] > 0).any(1) | (skin[:, seat, 1].min(1) < floor + UNDER)
    rows = np.flatnonzero(bent & ~carried)
    carried[rows] = _each(_is_above, skin[rows][:, seat], obstacles, floor)
    supported = touching.any(1) | (skin[..., 1].min(1) < floor + REACH) | carried
    rows = np.flatnonzero(~supported)
    supported[rows] = _each(_is_near, skin[rows], obstacles, floor)
    left, right = sole_patches()
    soles = human.skin(body, motion, np.concatenate([left, right]))[..., 1].min(1)
    return Support(bent, carried, supported, skin[:, seat, 1].min(1), soles.astype(np.float64))


def measures(
    motion: Motion,
    goal: Goal | None,
    obstacles: Obstacles,
    floor: float,
    body: Human | None = None,
    found: tuple[np.ndarray, np.ndarray] | None = None,
    skin: np.ndarray | None = None,
) -> dict[str, float | None]:
    """Compute the guarded measures of a take; arguments as for `observe`.

    air_squat_s: longest run, seconds, with both knees bent more than 50 degrees and nothing within 6 cm under hips and
    thighs. unsupported_s: longest run without any support, feet included; running excepted. seated_speed_m_s: fastest
    pelvis while seated, None for a take that does not sit. hanging_feet_cm: height of the lowest sole over the floor
    during the hold, on seats lower than 42 cm; None for others.
    """
    if len(motion) < 2:
        return dict(NONE)
    seen = observe(motion, obstacles, floor, body, found, skin)
    velocity = np.gradient(motion.root, 1 / motion.fps, axis=0)
    return {
        "air_squat_s": longest(_squats(seen, motion.fps)) / motion.fps,
        "unsupported_s": _flight(seen, _runs(motion, velocity), motion.fps),
        "seated_speed_m_s": _seated_speed(seen, velocity, motion.fps),
        "hanging_feet_cm": _hanging(seen, goal, floor, motion.fps),
    }


def longest(flags: np.ndarray) -> int:
    """Return the length of the longest run of set flags (T,)."""
    edges = np.flatnonzero(np.diff(np.r_[0, flags.astype(np.int8), 0]))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _squats(seen: Support, fps: float) -> np.ndarray:
    """Flag the frames (T,) of squats in the air, those in which the seat is only touched in passing among them."""
    squats = seen.bent & ~seen.carried
    frames = np.flatnonzero(squats)
    for first, last in zip(frames[:-1], frames[1:], strict=True):
        if 1 < last - first <= TOUCHED * fps and seen.bent[first:last].all():
            squats[first:last] = True
    return squats


def _flight(seen: Support, running: np.ndarray, fps: float) -> float:
    """Return the longest run without support, seconds, without the flights of running (T,) bodies, which are short."""
    longest_of_all = longest(~seen.supported) / fps
    return longest_of_all if longest_of_all > STRIDE else longest(~seen.supported & ~running) / fps


def _runs(motion: Motion, velocity: np.ndarray) -> np.ndarray:
    """Flag the frames (T,) in which the body runs. velocity: (T, 3) of the pelvis."""
    speed = np.hypot(velocity[:, 0], velocity[:, 2])
    if motion.actions is None:
        return speed > RUNNING
    # The label alone also stands over turns on the spot.
    return (speed > RUNNING) | ((motion.actions[:, ACTIONS.index("run")] > 0.5) & (speed > JOGGING))


def _seated_speed(seen: Support, velocity: np.ndarray, fps: float) -> float | None:
    """Return the pelvis' highest speed, m/s, in runs of seated frames without their first and last moments."""
    seated, margin = seen.bent & seen.carried, round(FALL_IN * fps)
    inner = seated.copy()
    for k in range(1, margin + 1):
        inner[k:] &= seated[:-k]
        inner[:-k] &= seated[k:]
    return float(np.linalg.norm(velocity[inner], axis=-1).max()) if inner.any() else None


def _hanging(seen: Support, goal: Goal | None, floor: float, fps: float) -> float | None:
    """Return the centimetres between the lowest sole and the floor in the hold on a low seat, else None."""
    hold = slice(-max(round(HOLD * fps), 1), None)
    if goal is None or goal.action != "sit" or not (seen.bent & seen.carried)[hold].all():
        return None
    if np.median(seen.seat[hold]) - floor >= LOW_SEAT:
        return None
    return float(max(np.median(seen.sole[hold]) - floor, 0.0) * 100)


def seat_skin(body: Human) -> np.ndarray:
    """Return indices among the collision vertices of the back of pelvis and thighs: what people sit on."""
    main = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], axis=1)[:, 0]
    main = main[body.collision]
    places = body.vertices[body.collision]
    behind = places[:, 2] < body.joints[main][:, 2]
    carrying = np.isin(main, [INDEX[name] for name in ("pelvis", "left_hip", "right_hip")])
    return np.flatnonzero(carrying & behind)


def _each(
    test: Callable[[np.ndarray, np.ndarray], bool], points: np.ndarray, obstacles: Obstacles, floor: float
) -> np.ndarray:
    """Return for each frame of points (T, N, 3) whether they pass a test with the surface samples around them."""
    result = np.zeros(len(points), bool)
    for first in range(0, len(points), CHUNK):
        part = points[first : first + CHUNK]
        samples = obstacles.samples(part.min((0, 1)) - 2 * UNDER, part.max((0, 1)) + 2 * UNDER, floor)
        for k, own in enumerate(part):
            low, high = own.min(0) - UNDER - 0.02, own.max(0) + UNDER
            close = samples[in_box(samples, low, high)]
            result[first + k] = len(close) > 0 and test(own, close)
    return result


def _is_above(points: np.ndarray, samples: np.ndarray) -> bool:
    """Whether a sample (M, 3) is up to 6 cm under one of some points (N, 3), 1.5 cm to the side at most."""
    near = cKDTree(samples[:, [0, 2]]).query_ball_point(points[:, [0, 2]], ASIDE)
    count = np.fromiter(map(len, near), int, len(near))
    if not count.any():
        return False
    below = (
        np.repeat(points[:, 1], count) - samples[np.fromiter(chain.from_iterable(near), int, count.sum()), 1]
    )
    return bool(((below >= 0) & (below <= UNDER)).any())


def _is_near(points: np.ndarray, samples: np.ndarray) -> bool:
    """Whether a sample (M, 3) is within 3 cm of the skin at points (N, 3)."""
    return bool(np.isfinite(cKDTree(points).query(samples, distance_upper_bound=NEAR)[0]).any())
