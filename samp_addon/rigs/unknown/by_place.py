"""Which bone of a symmetric body is which joint, by hierarchy and place alone."""

from __future__ import annotations

import numpy as np

from .tree import Tree, spine_joints

MIDDLE = 0.012
"""Distance from the plane of symmetry within which a bone is in the middle, relative to the body's extent."""


def by_place(heads: np.ndarray, tree: Tree) -> dict[str, int]:
    """Return joint -> bone of a symmetric body with two pairs of limbs, or nothing for another one.

    Legs hang on a bone below that of the arms; left is to the left of where the feet point.
    """
    side = _side_axis(heads)
    across = heads[:, side] - np.median(heads[:, side])
    middle = np.abs(across) < MIDDLE * np.ptp(heads, axis=0).max()
    roots = [b for b, parent in enumerate(tree.parents) if not middle[b] and parent >= 0 and middle[parent]]
    limbs = sorted((tree.main_path(b, heads) for b in roots), key=lambda limb: -_length(heads[limb]))
    limbs = [limb for limb in limbs if len(limb) >= 3][:4]
    holders = [tree.parents[limb[0]] for limb in limbs]
    arms_on = max(holders, key=lambda bone: tree.depth[bone], default=-1)
    legs_on = min(holders, key=lambda bone: tree.depth[bone], default=-1)
    if len(limbs) < 4 or holders.count(arms_on) != 2 or holders.count(legs_on) != 2 or legs_on == arms_on:
        return {}
    up = heads[arms_on] - heads[legs_on]
    up[side] = 0.0
    up = np.eye(3)[np.abs(up).argmax()] * np.sign(up[np.abs(up).argmax()])
    legs = [_leg(limb, heads @ up) for limb, on in zip(limbs, holders, strict=True) if on == legs_on]
    ahead = sum((heads[leg["foot"]] - heads[leg["ankle"]] for leg in legs if "foot" in leg), np.zeros(3))
    left = np.cross(up, ahead)[side] if ahead.any() else 1.0
    found = list(zip([limb[0] for limb in limbs if tree.parents[limb[0]] == legs_on], legs, strict=True))
    found += [(limb[0], _arm(limb, heads)) for limb, on in zip(limbs, holders, strict=True) if on == arms_on]
    chosen = {"pelvis": legs_on}
    for root, parts in found:
        name = "left" if across[root] * left > 0 else "right"
        chosen |= {f"{name}_{part}": bone for part, bone in parts.items()}
    over = [bone for bone in np.flatnonzero(middle) if tree.parents[bone] == arms_on]
    neck = tree.main_path(max(over, key=lambda bone: heads[bone] @ up), heads, middle) if over else []
    chosen |= (
        dict(zip(("neck", "head"), neck, strict=False)) if len(neck) > 1 else dict.fromkeys(("head",), *neck)
    )
    spine = [*tree.between(legs_on, arms_on), arms_on]
    return chosen | dict(zip(*spine_joints(spine), strict=True))


def _side_axis(heads: np.ndarray) -> int:
    """Return the axis across which the places of the bones (B, 3) are most symmetric."""
    error = np.full(3, np.inf)
    for axis in np.flatnonzero(np.ptp(heads, axis=0) > 0.1 * np.ptp(heads, axis=0).max()):
        mirrored = heads.copy()
        mirrored[:, axis] = 2 * np.median(heads[:, axis]) - heads[:, axis]
        error[axis] = np.linalg.norm(mirrored[:, None] - heads, axis=-1).min(axis=1).mean()
    return int(error.argmin())


def _length(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _leg(limb: list[int], height: np.ndarray) -> dict[str, int]:
    """Return part -> bone of a leg: the ankle is the first bone near the ground, the knee half-way to it."""
    drop = height[limb[0]] - height[limb]
    ankle = max(int(np.argmax(drop >= 0.8 * drop.max())), 2)
    knee = 1 + int(np.argmin(np.abs(drop[1:ankle] - drop[ankle] / 2)))
    parts = {"hip": limb[0], "knee": limb[knee], "ankle": limb[ankle]}
    return parts | ({"foot": limb[ankle + 1]} if ankle + 1 < len(limb) else {})


def _arm(limb: list[int], heads: np.ndarray) -> dict[str, int]:
    """Return part -> bone of an arm that ends with the hand; of four bones or more, the first one is the collar."""
    first = 1 if len(limb) > 3 else 0
    along = np.linalg.norm(heads[limb] - heads[limb[first]], axis=1)
    elbow = first + 1 + int(np.argmin(np.abs(along[first + 1 : -1] - along[-1] / 2)))
    parts = {"shoulder": limb[first], "elbow": limb[elbow], "wrist": limb[-1]}
    return parts | ({"collar": limb[0]} if first else {})
