"""How deep a body and hard furniture are in each other, by both measures. Room frame, metres."""

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
EVERY, LOOKS = 4, 5  # frames between two in which the skin is looked at; frames in which the surfaces are
MOST_IN_USE = 0.0185  # metres of either depth in furniture that is in use
CONFIRMED, CONFIRMED_NEAR = 0.015, 0.035  # metres: depths to confirm, and to the next of points 3 cm apart


def skin_depth(obstacles: Obstacles, motion: Motion, body: human.Human) -> np.ndarray:
    """The deepest skin (T,) inside of things, metres."""
    return obstacles.depth(human.skin(body, motion, body.collision))[0].max(1)


def surface_depth(obstacles: Obstacles, motion: Motion, body: human.Human) -> np.ndarray:
    """The deepest surface sample (T,) inside the body, metres from the nearest skin."""
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
        # Skin that folds over itself in the groin faces inwards: points of the body's inside have to be near, too.
        if deepest > CONFIRMED:
            near = cKDTree(interior[frame]).query(samples[found.index])[0] < CONFIRMED_NEAR
            deepest = found.depth[near].max(initial=0.0)
        out[frame] = deepest
    return out


def deepest_in_use(obstacles: Obstacles, motion: Motion, body: human.Human) -> float:
    """The larger of both depths of a body that uses a piece, metres: the skin's in every EVERY-th frame of the motion,
    the surfaces' in LOOKS frames and in that of the deepest skin."""
    some = np.arange(0, len(motion), EVERY)
    skin = skin_depth(obstacles, motion.pose_slice(some), body)
    if skin.max() > MOST_IN_USE:
        return float(skin.max())
    looks = np.append(np.linspace(0, len(motion) - 1, LOOKS + 2).astype(int)[1:-1], some[skin.argmax()])
    return max(float(skin.max()), deepest(obstacles, motion.pose_slice(np.unique(looks)), body))


def deepest(obstacles: Obstacles, motion: Motion, body: human.Human) -> float:
    """The larger of both depths in any frame, metres; surfaces that are less than about 1 cm deep are left out.

    Fast: only the few samples close to points of the body's inside are looked at.
    """
    worst = float(skin_depth(obstacles, motion, body).max(initial=0.0))
    surface = surface_of(human.load())  # all bodies have the same triangles
    interior = probes.interior(motion.root, motion.rotations)
    low, high = interior.min((0, 1)) - CONFIRMED_NEAR, interior.max((0, 1)) + CONFIRMED_NEAR
    samples = obstacles.samples(low, high)
    if not len(samples):
        return worst
    close = []
    for points in interior:
        tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
        close.append(np.flatnonzero(np.isfinite(tree.query(samples, distance_upper_bound=CONFIRMED_NEAR)[0])))
    some = np.array([frame for frame, near in enumerate(close) if len(near)], int)
    part = motion.pose_slice(some)
    joints = skeleton.forward_kinematics(part.root, complete(part.rotations), body.joints)[0]
    for frame, skin, own in zip(some, human.skin(body, part, surface.vertices), joints, strict=True):
        worst = max(worst, surface.deepest(skin, samples[close[frame]], own))
    return worst
