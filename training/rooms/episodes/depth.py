"""Mutual penetration of a body and hard furniture, by both measures. Room frame, metres."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ....samp_addon import skeleton
from ....samp_addon.body import human
from ....samp_addon.body.hands import complete
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.evaluation.skin_depth import SkinSurface, surface_of
from ....samp_addon.motion import Motion
from ...fitting.shapes import probes

SOFT = ("sofa", "armchair", "l_sofa", "bed", "bunk_bed", "lounger", "pouf", "office_chair")
EVERY, LOOKS = 4, 5  # stride of the frames in which the skin is measured; number of those for surfaces
MOST_IN_USE = 0.017  # largest depth (m), of either kind, in furniture in use
# Joints at both ends of limbs, relative length including the hand, and radius (m) of the search for surfaces.
LIMBS = tuple(
    (f"{side}_{upper}", f"{side}_{lower}", along, reach)
    for upper, lower, along, reach in (("elbow", "wrist", 1.4, 0.045), ("knee", "ankle", 1.0, 0.055))
    for side in ("left", "right")
)
LIMB_LOOKS, LIMB_APART = 4, 2
TOGETHER = 8  # frames whose surroundings are queried together
CONFIRMED, CONFIRMED_NEAR = (
    0.015,
    0.035,
)  # metres: depth to confirm, and distance to interior points (3 cm apart)
# Bones, and the radius of the flesh around them in metres.
BONES = [(1, 4), (2, 5), (4, 7), (5, 8), (7, 10), (8, 11), (0, 3), (3, 6), (6, 9), (9, 12), (12, 15), (16, 18),
         (17, 19), (18, 20), (19, 21)]  # fmt: skip
RADII = np.array(
    [0.075, 0.075, 0.05, 0.05, 0.035, 0.035, 0.11, 0.11, 0.11, 0.08, 0.085, 0.045, 0.045, 0.038, 0.038]
)
SHARES = (0.0, 0.35, 0.7)  # positions of the probe points along a bone; its end belongs to the next bone
BEYOND = {
    (18, 20): (1.2, 1.45, 1.7),
    (19, 21): (1.2, 1.45, 1.7),
    (7, 10): (-0.3, 1.35),
    (8, 11): (-0.3, 1.35),
}
"""Positions along the bones, in shares, of points in hands, toes and heels."""
ENDS = 0.022  # radius of the flesh there, metres


def skin_depth(obstacles: Obstacles, motion: Motion, body: human.Human) -> np.ndarray:
    """Return the largest depth (T,), metres, of the skin inside obstacles."""
    return obstacles.depth(human.skin(body, motion, body.collision))[0].max(1)


def surface_depth(obstacles: Obstacles, motion: Motion, body: human.Human) -> np.ndarray:
    """Return the largest depth (T,), metres, of surface samples inside the body, to the nearest skin."""
    surface = SkinSurface(body)
    interior = probes.interior(motion.root, motion.rotations)
    joints = skeleton.forward_kinematics(motion.root, complete(motion.rotations), body.joints)[0]
    out = np.zeros(len(motion))
    for frame, skin in enumerate(human.skin(body, motion, surface.vertices)):
        low, high = joints[frame].min(0) - surface.reach, joints[frame].max(0) + surface.reach
        samples = obstacles.samples(low, high)
        samples = samples[surface.near(joints[frame], samples)]
        found = surface.inside(skin, samples, joints[frame])
        deepest = found.depth.max(initial=0.0)
        # Folded skin in the groin faces inwards, so interior points have to be near as well.
        if deepest > CONFIRMED:
            near = cKDTree(interior[frame]).query(samples[found.index])[0] < CONFIRMED_NEAR
            deepest = found.depth[near].max(initial=0.0)
        out[frame] = deepest
    return out


def deepest_in_use(obstacles: Obstacles, motion: Motion, body: human.Human) -> float:
    """Return the larger of both depths, metres, of a body that uses a piece.

    The skin is measured in every EVERY-th frame; surfaces in LOOKS frames, in that of the deepest skin, and in those
    with a forearm or shank close to a surface.
    """
    some = np.arange(0, len(motion), EVERY)
    few = motion.pose_slice(some)
    skin = skin_depth(obstacles, few, body)
    if skin.max() > MOST_IN_USE:
        return float(skin.max())
    looks = np.linspace(0, len(motion) - 1, LOOKS + 2).astype(int)[1:-1]
    looks = np.unique([*looks, some[skin.argmax()], *some[_nearest_limbs(obstacles, few)]])
    return max(float(skin.max()), float(near_surface_depth(obstacles, motion.pose_slice(looks), body).max()))


def _nearest_limbs(obstacles: Obstacles, motion: Motion) -> list[int]:
    """Return up to LIMB_LOOKS frames for each forearm and shank in which it is closest to a surface.

    The frames of a limb are more than LIMB_APART apart.
    """
    joints, _ = motion.forward_kinematics()
    found: list[int] = []
    for upper, lower, along, reach in LIMBS:
        start, end = (joints[:, skeleton.INDEX[name], None] for name in (upper, lower))
        points = start + np.linspace(0, along, 6)[:, None] * (end - start)
        samples = obstacles.samples(points.min((0, 1)) - reach, points.max((0, 1)) + reach)
        if not len(samples):
            continue
        gap = _tree(samples).query(points.reshape(-1, 3), distance_upper_bound=reach)[0]
        gap = gap.reshape(len(motion), -1).min(1)
        for _ in range(LIMB_LOOKS):
            frame = int(gap.argmin())
            if not np.isfinite(gap[frame]):
                break
            found.append(frame)
            gap[max(frame - LIMB_APART, 0) : frame + LIMB_APART + 1] = np.inf
    return found


def _tree(points: np.ndarray) -> cKDTree:
    return cKDTree(points, balanced_tree=False, compact_nodes=False)


def deepest(obstacles: Obstacles, motion: Motion, body: human.Human) -> float:
    """Return the larger of both depths in any frame, metres; see `near_surface_depth`."""
    skin = float(skin_depth(obstacles, motion, body).max(initial=0.0))
    return max(skin, float(near_surface_depth(obstacles, motion, body).max(initial=0.0)))


def near_surface_depth(obstacles: Obstacles, motion: Motion, body: human.Human) -> np.ndarray:
    """Return surface_depth (T,), metres, without surfaces less than about 1 cm deep.

    Fast, because it measures only samples close to interior points of the body.
    """
    out = np.zeros(len(motion))
    surface = surface_of(human.load())  # all bodies have the same triangles
    interior = probes.interior(motion.root, motion.rotations)
    low, high = interior.min((0, 1)) - CONFIRMED_NEAR, interior.max((0, 1)) + CONFIRMED_NEAR
    samples = obstacles.samples(low, high)
    if not len(samples):
        return out
    close = {}
    for first in range(0, len(interior), TOGETHER):
        bodies = interior[first : first + TOGETHER]
        here = _boxed(samples, bodies)
        for frame, points in enumerate(bodies, first):
            boxed = here[_boxed(samples[here], points)]
            if not len(boxed):
                continue
            near = np.isfinite(_tree(points).query(samples[boxed], distance_upper_bound=CONFIRMED_NEAR)[0])
            if near.any():
                close[frame] = boxed[near]
    if not close:
        return out
    part = motion.pose_slice(np.array(list(close)))
    joints = skeleton.forward_kinematics(part.root, complete(part.rotations), body.joints)[0]
    skin = human.skin(body, part, surface.vertices)
    for (frame, rows), vertices, own in zip(close.items(), skin, joints, strict=True):
        out[frame] = surface.deepest(vertices, samples[rows], own)
    return out


def _boxed(samples: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the indices of samples (N, 3) in the box of points (..., 3), widened by CONFIRMED_NEAR."""
    points = points.reshape(-1, 3)
    low, high = points.min(0) - CONFIRMED_NEAR, points.max(0) + CONFIRMED_NEAR
    return np.flatnonzero(((samples > low) & (samples < high)).all(1))


def bone_points(
    root: np.ndarray, rotations: np.ndarray, rest: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return points on the bones (T, P, 3) and the radius of the flesh around each (P,), metres.

    rest: (J, 3) joints of the body, None for the default human's.
    """
    rest = skeleton.default_rest_joints() if rest is None else rest
    joints, _ = skeleton.forward_kinematics(root, rotations, rest)
    points = [joints[:, a] + share * (joints[:, b] - joints[:, a]) for a, b in BONES for share in SHARES]
    ends = [
        joints[:, a] + share * (joints[:, b] - joints[:, a])
        for (a, b), more in BEYOND.items()
        for share in more
    ]
    radii = np.concatenate([np.repeat(RADII, len(SHARES)), np.full(len(ends), ENDS)])
    return np.stack([*points, *ends], 1), radii
