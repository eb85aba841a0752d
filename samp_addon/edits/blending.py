"""A take joined with another motion over some frames. Network frame, metres, radians."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .. import rotation
from ..body.hands import complete
from ..easing import smoothstep
from ..errors import SampError
from ..frames import direction_yaw, wrap_angle
from ..motion import Motion
from ..refine.feet.foot_lock import lock_to_plans
from ..refine.feet.plan import plan_feet
from ..refine.proportions.footprints import Footprints

MARGIN = 0.6
"""Seconds beside the blend within which feet are held where they stand."""


@dataclass(frozen=True)
class Blend:
    """Two motions as one. first, last: frames of the blend."""

    motion: Motion
    first: int
    last: int


def blended(before: Motion, after: Motion, count: int, moves_before: bool = False) -> Blend:
    """Join two motions, the last ``count`` frames of the first blended into the first ones of the second.

    The second is moved over the floor and turned, so that pelvis and facing agree in the middle of the blend; with
    ``moves_before`` the first is. Feet that stand are held where they stand. Frames away from the blend stay as they
    are. Raises SampError where a motion is shorter than the blend.
    """
    shortest = min(len(before), len(after))
    if not 1 <= count < shortest:
        raise SampError(f"The blend takes {count} frames; choose from 1 to {shortest - 1}.")
    before, after = (replace(one, rotations=complete(one.rotations)) for one in (before, after))
    middle = count // 2
    if moves_before:
        before = _onto(before, len(before) - count + middle, after, middle)
    else:
        after = _onto(after, middle, before, len(before) - count + middle)
    joined = _crossfaded(before, after, count)
    first = len(before) - count
    return Blend(_held(joined, first, len(before) - 1), first, len(before) - 1)


def _onto(motion: Motion, frame: int, other: Motion, at: int) -> Motion:
    """Move a motion over the floor and turn it, so that its frame stands and faces like another one's."""
    yaw = float(direction_yaw(other.headings()[at])) - float(direction_yaw(motion.headings()[frame]))
    turn = rotation.about_y(float(wrap_angle(yaw)))
    away = motion.root - motion.root[frame] * [1.0, 0.0, 1.0]
    root = rotation.rotate(np.broadcast_to(turn, (len(away), 4)), away) + other.root[at] * [1.0, 0.0, 1.0]
    rotations = motion.rotations.copy()
    rotations[:, 0] = rotation.multiply(np.broadcast_to(turn, rotations[:, 0].shape), rotations[:, 0])
    return replace(motion, root=root, rotations=rotations)


def _crossfaded(before: Motion, after: Motion, count: int) -> Motion:
    """Return both motions in a row, count frames of them mixed."""
    share = smoothstep(np.arange(1, count + 1) / (count + 1))[:, None]
    end, begin = slice(len(before) - count, None), slice(0, count)
    mixed = before.root[end] + share * (after.root[begin] - before.root[end])
    turned = rotation.slerp(before.rotations[end], after.rotations[begin], share)
    rotations = np.concatenate([before.rotations[:-count], turned, after.rotations[count:]])

    def weights(a: np.ndarray | None, b: np.ndarray | None) -> np.ndarray | None:
        if a is None or b is None:
            return None
        return np.concatenate([a[:-count], a[end] + share * (b[begin] - a[end]), b[count:]])

    start = after.interaction_start
    return replace(
        before,
        root=np.concatenate([before.root[:-count], mixed, after.root[count:]]),
        rotations=rotation.continuous(rotations),
        contacts=weights(before.contacts, after.contacts),
        actions=weights(before.actions, after.actions),
        interaction_start=before.interaction_start if start is None else len(before) - count + start,
    )


def _held(motion: Motion, first: int, last: int) -> Motion:
    """Hold the feet of stances around the blend where they stand."""
    margin = max(int(round(MARGIN * motion.fps)), 2)
    low, high = max(first - margin, 0), min(last + margin, len(motion) - 1)
    part = motion.pose_slice(slice(low, high + 1))
    prints = Footprints.of(part)
    locked = lock_to_plans(part, plan_feet(part, prints), prints)
    at = np.arange(low, high + 1)
    share = smoothstep(np.minimum(at - first + margin, last + margin - at) / margin)[:, None]
    root, rotations = motion.root.copy(), motion.rotations.copy()
    root[at] += share * (locked.root - root[at])
    rotations[at] = np.where(
        share[..., None] > 0, rotation.slerp(rotations[at], locked.rotations, share), rotations[at]
    )
    return replace(motion, root=root, rotations=rotation.continuous(rotations))
