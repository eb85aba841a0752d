"""Quaternions (w, x, y, z), matrices, axis-angle and the 6D form, for numpy arrays of any leading shape."""

from __future__ import annotations

import numpy as np


def normalise(q: np.ndarray) -> np.ndarray:
    """Scale quaternions (..., 4) to unit length."""
    return q / np.maximum(np.linalg.norm(q, axis=-1, keepdims=True), 1e-12)


def quaternion_to_matrix(q: np.ndarray) -> np.ndarray:
    """Convert unit quaternions (..., 4) to rotation matrices (..., 3, 3)."""
    w, x, y, z = _components_first(q)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def uprightness(q: np.ndarray) -> np.ndarray:
    """Return the cosines (...) between the vertical and the y axis turned by unit quaternions (..., 4)."""
    return 1 - 2 * (q[..., 1] * q[..., 1] + q[..., 3] * q[..., 3])


def matrix_to_quaternion(m: np.ndarray) -> np.ndarray:
    """Convert rotation matrices (..., 3, 3) to unit quaternions (..., 4); stable for every angle."""
    m = np.asarray(m)
    d0, d1, d2 = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    # Four candidates, each accurate where its own component is large; take the largest.
    table = np.stack(
        [
            np.stack(
                [
                    1 + d0 + d1 + d2,
                    m[..., 2, 1] - m[..., 1, 2],
                    m[..., 0, 2] - m[..., 2, 0],
                    m[..., 1, 0] - m[..., 0, 1],
                ],
                -1,
            ),
            np.stack(
                [
                    m[..., 2, 1] - m[..., 1, 2],
                    1 + d0 - d1 - d2,
                    m[..., 0, 1] + m[..., 1, 0],
                    m[..., 0, 2] + m[..., 2, 0],
                ],
                -1,
            ),
            np.stack(
                [
                    m[..., 0, 2] - m[..., 2, 0],
                    m[..., 0, 1] + m[..., 1, 0],
                    1 - d0 + d1 - d2,
                    m[..., 1, 2] + m[..., 2, 1],
                ],
                -1,
            ),
            np.stack(
                [
                    m[..., 1, 0] - m[..., 0, 1],
                    m[..., 0, 2] + m[..., 2, 0],
                    m[..., 1, 2] + m[..., 2, 1],
                    1 - d0 - d1 + d2,
                ],
                -1,
            ),
        ],
        axis=-2,
    )
    best = np.argmax(np.stack([table[..., k, k] for k in range(4)], -1), -1)
    return normalise(np.take_along_axis(table, best[..., None, None], axis=-2)[..., 0, :])


def multiply_components(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the Hamilton product of quaternions with the components first, (4, ...); faster than `multiply`."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return np.array(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the Hamilton product of quaternions (..., 4)."""
    return _components_last(multiply_components(_components_first(a), _components_first(b)))


def _components_first(values: np.ndarray) -> np.ndarray:
    """Move the last axis to the front; ten times as fast as np.moveaxis."""
    values = np.asarray(values)
    return values.transpose(-1, *range(values.ndim - 1))


def _components_last(values: np.ndarray) -> np.ndarray:
    """Move the first axis to the end, contiguous in memory."""
    return np.ascontiguousarray(values.transpose(*range(1, values.ndim), 0))


def conjugate(q: np.ndarray) -> np.ndarray:
    """Return the inverse of unit quaternions (..., 4)."""
    return np.asarray(q) * np.array([1.0, -1.0, -1.0, -1.0])


def change_basis(q: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Express rotations, quaternions (..., 4), in other axes: the rows of ``basis`` (3, 3) or (J, 3, 3)."""
    result = q.copy()
    result[..., 1:] = np.einsum("...ab,...b->...a", basis, q[..., 1:])
    return result


def rotate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Rotate vectors (..., 3) by unit quaternions (..., 4)."""
    return _components_last(rotate_components(_components_first(q), _components_first(v)))


def rotate_components(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Rotate vectors (3, ...) by unit quaternions (4, ...), components first; faster than `rotate`."""
    # Written out: np.cross takes four times as long on short arrays.
    w, x, y, z = q
    a, b, c = v
    s, t, u = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return np.array([a + w * s + y * u - z * t, b + w * t + z * s - x * u, c + w * u + x * t - y * s])


def from_axis_angle(r: np.ndarray) -> np.ndarray:
    """Convert rotation vectors (..., 3) in radians to quaternions (..., 4)."""
    r = np.asarray(r, dtype=np.float64)
    angle = np.linalg.norm(r, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * r], axis=-1)


def to_axis_angle(q: np.ndarray) -> np.ndarray:
    """Convert unit quaternions (..., 4) to rotation vectors (..., 3) with angles in [0, pi] radians."""
    q = np.where(q[..., :1] < 0, -q, q)
    s = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(s, q[..., :1])
    return np.where(s > 1e-9, angle / np.maximum(s, 1e-12), 2.0) * q[..., 1:]


def about_y(yaw: np.ndarray | float) -> np.ndarray:
    """Return quaternions (..., 4) of rotations about the vertical axis of the network frame; yaw in radians."""
    yaw = np.asarray(yaw, dtype=np.float64)
    zero = np.zeros_like(yaw)
    return np.stack([np.cos(yaw / 2), zero, np.sin(yaw / 2), zero], axis=-1)


def slerp(a: np.ndarray, b: np.ndarray, t: np.ndarray | float) -> np.ndarray:
    """Interpolate quaternions (..., 4) spherically along the shorter arc; ``t`` broadcasts to (...)."""
    t = np.asarray(t, dtype=np.float64)[..., None]
    dot = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(dot < 0, -b, b)
    dot = np.clip(np.abs(dot), 0.0, 1.0)
    theta = np.arccos(dot)
    s = np.sin(theta)
    small = s < 1e-6
    safe = np.where(small, 1.0, s)
    wa = np.where(small, 1 - t, np.sin((1 - t) * theta) / safe)
    wb = np.where(small, t, np.sin(t * theta) / safe)
    return normalise(wa * a + wb * b)


def continuous(q: np.ndarray) -> np.ndarray:
    """Choose the signs of quaternions (T, ..., 4) so that no frame jumps to the antipode."""
    q = np.array(q, dtype=np.float64)
    flips = np.cumprod(np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0, -1.0, 1.0), axis=0)
    q[1:] *= flips[..., None]
    return q


def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the smallest rotations, quaternions (..., 4), that turn vectors a (..., 3) onto b (..., 3)."""
    a = a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-12)
    b = b / np.maximum(np.linalg.norm(b, axis=-1, keepdims=True), 1e-12)
    w = 1 + np.sum(a * b, axis=-1, keepdims=True)
    return normalise(np.concatenate([np.maximum(w, 1e-9), np.cross(a, b)], axis=-1))
