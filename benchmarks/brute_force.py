"""Independent, slower computations of the measures of takes, for comparison. Network frame, metres.

Support by vertical rays through all triangles near the body; depth by winding numbers and distances over all triangles
of body and scene. Nothing of samp_addon/evaluation is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..samp_addon.body import human
from ..samp_addon.motion import Motion
from ..samp_addon.scene.geometry import closest_points, sample_surface
from ..samp_addon.skeleton import INDEX

BENT, UNDER, NEAR = 50.0, 0.06, 0.03
INSIDE = 0.05
"""Height over the skin at which rays start, metres, since a surface inside the body supports it as well."""

SPACING = 0.01
MOVING = 0.2
"""Seconds at both ends of a seated run in which motion of the pelvis is allowed."""

RUNNING = 1.8
RATE = 15.0
"""Frames per second that are measured."""

CLOSE = 0.17
"""Distance from the nearest vertex beyond which no point is inside a body, metres."""


@dataclass(frozen=True)
class Found:
    """Longest squat in the air and flight, seconds, and the fastest seated pelvis, m/s."""

    air_squat: float
    flight: float
    glide: float


def support(motion: Motion, triangles: np.ndarray, floor: float) -> Found:
    """Measure the support of a take's body in a scene (F, 3, 3). floor: its height, metres."""
    step = max(1, round(motion.fps / RATE))
    rows = np.arange(0, len(motion), step)
    part, rate = motion.pose_slice(rows), motion.fps / step
    body = human.load()
    skin = human.skin(body, part).astype(np.float64)
    bent = _knees(part) > BENT
    under = np.flatnonzero(_carrying(body))[::2]
    carried, held = np.zeros(len(part), bool), np.zeros(len(part), bool)
    for k, vertices in enumerate(skin):
        low, high = vertices.min(0) - 0.1, vertices.max(0) + 0.1
        near = triangles[(triangles.max(1) >= low).all(1) & (triangles.min(1) <= high).all(1)]
        held[k] = vertices[:, 1].min() < floor + NEAR or _touches(vertices, near, low, high)
        seat = vertices[under]
        carried[k] = seat[:, 1].min() < floor + UNDER or (bent[k] and _over(seat, near))
    speed = np.linalg.norm(np.gradient(part.root, 1 / rate, axis=0), axis=-1)
    flat = np.hypot(*np.gradient(part.root[:, [0, 2]], 1 / rate, axis=0).T)
    seated = bent & carried
    margin = round(MOVING * rate)
    inner = np.array([seated[max(0, k - margin) : k + margin + 1].all() for k in range(len(seated))])
    return Found(
        _longest(bent & ~carried) / rate,
        _longest(~held & ~carried & (flat <= RUNNING)) / rate,
        float(speed[inner].max(initial=0.0)),
    )


def depth(vertices: np.ndarray, triangles: np.ndarray, floor: float | None = None) -> float:
    """Return the depth, metres, of surfaces (F, 3, 3) inside a body with vertices (V, 3).

    It is measured at points SPACING apart and above the floor whose winding number is not 0, to the nearest of all the
    skin's triangles.
    """
    skin = vertices[_faces()]
    low, high = vertices.min(0), vertices.max(0)
    near = triangles[(triangles.max(1) >= low).all(1) & (triangles.min(1) <= high).all(1)]
    points = _samples(near, low, high)
    if floor is not None:
        points = points[points[:, 1] > floor + SPACING]
    if len(points):
        points = points[cKDTree(vertices).query(points)[0] < CLOSE]
    inside = points[[abs(_winding(point, skin)) > 0.5 for point in points]] if len(points) else points
    return max((float(_distance(point, skin)) for point in inside), default=0.0)


def _samples(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return random points of triangles (F, 3, 3) in a box, about SPACING apart."""
    if not len(triangles):
        return np.zeros((0, 3))
    edges = triangles[:, 1:] - triangles[:, :1]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=-1).sum() / 2
    if area < 1e-8:
        return np.zeros((0, 3))
    points = sample_surface(triangles, min(int(2 * area / SPACING**2) + 1, 400_000), seed=1)[0]
    return points[((points >= low) & (points <= high)).all(1)]


def _touches(vertices: np.ndarray, triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    points = _samples(triangles, low, high)
    return bool(len(points) and (cKDTree(points).query(vertices, distance_upper_bound=NEAR)[0] < NEAR).any())


def _over(points: np.ndarray, triangles: np.ndarray) -> bool:
    """Return whether a triangle (F, 3, 3) is vertically within UNDER below one of the points (N, 3)."""
    a, b, c = (triangles[:, k][:, [0, 2]] for k in range(3))
    size = _cross2(b - a, c - a)
    level = np.abs(size) > 1e-12
    a, b, c, size, corner = a[level], b[level], c[level], size[level], triangles[level][:, :, 1]
    for point in points:
        place = point[[0, 2]]
        u, v = _cross2(place - a, c - a) / size, _cross2(b - a, place - a) / size
        hit = (u >= 0) & (v >= 0) & (u + v <= 1)
        height = corner[:, 0] + u * (corner[:, 1] - corner[:, 0]) + v * (corner[:, 2] - corner[:, 0])
        below = point[1] - height[hit]
        if ((below <= UNDER) & (below >= -INSIDE)).any():
            return True
    return False


def _cross2(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _knees(motion: Motion) -> np.ndarray:
    """Return the smaller flexion (T,) of both knees, degrees, by the law of cosines."""
    joints = motion.forward_kinematics()[0]
    angles = []
    for side in ("left", "right"):
        hip, knee, ankle = (joints[:, INDEX[f"{side}_{name}"]] for name in ("hip", "knee", "ankle"))
        a, b = (np.linalg.norm(p - q, axis=-1) for p, q in ((hip, knee), (knee, ankle)))
        c = np.linalg.norm(hip - ankle, axis=-1)
        angles.append(180 - np.degrees(np.arccos(np.clip((a**2 + b**2 - c**2) / (2 * a * b), -1, 1))))
    return np.minimum(*angles)


def _carrying(body: human.Human) -> np.ndarray:
    """Flag vertices (V,) on the back of pelvis and thighs."""
    main = body.weight_joints[np.arange(len(body.vertices)), body.weights.argmax(1)]
    behind = body.vertices[:, 2] < body.joints[main][:, 2]
    return behind & np.isin(main, [INDEX[name] for name in ("pelvis", "left_hip", "right_hip")])


def _longest(flags: np.ndarray) -> int:
    best = run = 0
    for flag in flags:
        run = run + 1 if flag else 0
        best = max(best, run)
    return best


def _faces() -> np.ndarray:
    """Return the triangles (F, 3) of the skin, including eyes and teeth, which are inside."""
    quads = human.load().faces
    return np.concatenate([quads[:, :3], quads[quads[:, 2] != quads[:, 3]][:, [0, 2, 3]]])


def _winding(point: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (triangles[:, k] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    solid = np.einsum("ni,ni->n", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(np.arctan2(solid, below).sum() / (2 * np.pi))


def _distance(point: np.ndarray, triangles: np.ndarray) -> float:
    near = closest_points(np.tile(point, (len(triangles), 1)), triangles)
    return float(np.linalg.norm(near - point, axis=-1).min())
