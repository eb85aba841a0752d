"""A new end of a motion goes on with the speed of the frames before it, with feet that stand. Network frame, metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .. import rotation, skeleton
from ..body.hands import complete
from ..easing import smoothstep
from ..motion import Motion
from ..refine.feet.foot_lock import lock_to_plans
from ..refine.feet.plan import plan_feet
from ..refine.proportions.footprints import Footprints

TAKE_OVER, TURN_OVER = 0.27, 0.13
"""Seconds in which pelvis and joints go over from their speeds so far to those of the new end."""

CATCH_UP = 1.0
"""Seconds after that in which the pelvis gets back to where the new end has it."""

BEFORE, PLANTED, RISE = 0.6, 1.5, 0.25
"""Seconds before and after the join that are looked at for standing feet, and in which their correction begins."""


def continued(head: Motion, tail: Motion) -> Motion:
    """Return a tail, which begins in the last frame of ``head``, that goes on without a jump of speed.

    Both have the same rate and rest joints. The first frame and, after at most 2 seconds, all others stay as they are.
    """
    tail = replace(tail, rotations=complete(tail.rotations))
    head = replace(head, rotations=complete(head.rotations))
    if len(head) < 2 or len(tail) < 4:
        return tail
    at = np.arange(len(tail))
    length = min(max(int(round(TAKE_OVER * tail.fps)), 1), len(tail) - 2)
    share = smoothstep(1 - at / length)
    steps = np.diff(tail.root, axis=0)
    mixed = steps + share[:-1, None] * (head.root[-1] - head.root[-2] - steps)
    ahead = np.concatenate([np.zeros((1, 3)), np.cumsum(mixed - steps, axis=0)])
    back = min(int(round(CATCH_UP * tail.fps)), len(tail) - 1 - length)
    root = tail.root + smoothstep(1 - (at - length) / max(back, 1))[:, None] * ahead
    turn = rotation.multiply(rotation.conjugate(head.rotations[-2]), head.rotations[-1])
    length = min(max(int(round(TURN_OVER * tail.fps)), 1), length)
    share = smoothstep(1 - at / length)
    turns = rotation.from_axis_angle(rotation.to_axis_angle(turn) * at[: length + 1, None, None])
    going_on = rotation.multiply(np.broadcast_to(head.rotations[-1], turns.shape), turns)
    rotations = tail.rotations.copy()
    part = slice(1, length + 1)
    rotations[part] = rotation.slerp(rotations[part], going_on[1:], share[part, None])
    planted = _planted(head, replace(tail, root=root, rotations=rotations))
    made = planted.rotations
    # Hands and face are still: rounding would make them move, and give each a key on each frame.
    made[:, skeleton.BODY_COUNT :] = tail.rotations[:, skeleton.BODY_COUNT :]
    return replace(planted, rotations=rotation.continuous(made))


def _planted(head: Motion, tail: Motion) -> Motion:
    """Hold the feet that stand after the join where they stand."""
    before = head.pose_slice(slice(max(len(head) - int(BEFORE * head.fps), 0), len(head)))
    count = min(int(PLANTED * tail.fps), len(tail))
    both = replace(
        before,
        root=np.concatenate([before.root, tail.root[1:count]]),
        rotations=np.concatenate([before.rotations, tail.rotations[1:count]]),
    )
    prints = Footprints.of(both)
    locked = lock_to_plans(both, plan_feet(both, prints), prints)
    at, rise = np.arange(1, count), max(RISE * tail.fps, 1.0)
    share = smoothstep(np.minimum(at, count - 1 - at if count < len(tail) else np.inf) / rise)[:, None]
    root, rotations = tail.root.copy(), tail.rotations.copy()
    root[1:count] += share * (locked.root[len(before) :] - root[1:count])
    turned = rotation.slerp(rotations[1:count], locked.rotations[len(before) :], share)
    rotations[1:count] = turned
    return replace(tail, root=root, rotations=rotations)
