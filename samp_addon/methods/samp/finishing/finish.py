"""Finishing of a raw rollout: its end exactly on the goal, locked feet, and the heights of its floor."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .... import frames, rotation
from ....easing import smoothstep
from ....motion import Motion
from ....refine.feet.foot_lock import lock_feet
from ....vocabulary import ACTIONS, SEATED
from ..route import Route
from ..unfolding import Unfolded
from . import crossing, hands, high_seat, seated_pelvis
from .ground.narrow_way import FreeFloor, keep_on
from .ground.stairs import climb
from .ground.terrain import Ground, follow
from .hovering import lowered
from .leaning import SeatBack
from .raised_back import raise_trunk
from .resting import RestingTop
from .seat_edge import SeatFront
from .uncurled import uncurled
from .unhurried import unhurried

LAST_STRETCH = 1.2  # metres walked before the goal over which the remaining error is removed
SMOOTHING = 1.5  # frames at 30 fps
MIN_SINKING = 0.08  # metres by which the pelvis sinks onto an ordinary seat; less is a high stool
PERCHING = 30.0  # frames at 30 fps in which a body moves back onto a high stool
SEATED_WEIGHT = 0.9  # share of the way down from which a body counts as seated
# Of the trunk over the mattress, against a headboard, where the network may lie flat.
HALF_SITTING = np.radians(40.0)
BUSY = 0.5  # weight of the action above which the character is sitting or lying

CORRECTIONS = (
    "smoothing",
    "goal",
    "pelvis",
    "shins",
    "leaning",
    "hands",
    "crossing",
    "raised_back",
    "spine",
    "hovering",
    "limbs",
    "narrow_way",
    "feet",
    "pace",
)
"""Names of the corrections, in their order, so that an evaluation can leave out one at a time."""


def interaction_start(motion: Motion, action: str) -> int | None:
    """Return the first frame of the last run in which the action has more than half the weight; None for walking."""
    if action not in SEATED:
        return None
    busy = motion.actions[:, ACTIONS.index(action)] > BUSY
    idle = np.flatnonzero(~busy)
    return int(min(idle[-1] + 1, len(motion) - 1)) if len(idle) else 0


def finish(
    motion: Motion,
    route: Route,
    travelled: np.ndarray,
    action: str,
    front: SeatFront | None = None,
    top: RestingTop | None = None,
    back: SeatBack | None = None,
    table: np.ndarray | None = None,
    posture: Collection[str] = (),
    ground: Ground | None = None,
    free: FreeFloor | None = None,
    unfolded: Unfolded | None = None,
    without: Collection[str] = (),
) -> Motion:
    """Return the finished take: on its goal, feet locked, at the heights of its floor.

    travelled: (T,) metres along the route. front: of the seat. top: of the object that the body rests on. back: of
    the seat, if the body leans on it. table: places (2, 3) of the left and the right wrist on it. posture: of the rest.
    ground: under the feet. free: floor of a narrow way. unfolded: the path over stairs, on which the motion is.
    without: CORRECTIONS that are left out.
    """
    wanted = frozenset(CORRECTIONS) - frozenset(without)
    goal = route.goals[-1]
    start = interaction_start(motion, action)
    motion = replace(smoothed(motion) if "smoothing" in wanted else motion, interaction_start=start)
    if "goal" in wanted:
        motion = settle_on_goal(motion, goal, action)
    if start is not None:
        motion = _on_object(motion, goal, front, top, back, table, posture, wanted)
    if "narrow_way" in wanted and unfolded is None:
        seated = 0.0 if start is None else _lift_weight(motion)
        motion = keep_on(motion, free, np.ones(len(motion)) - seated)
    if "feet" in wanted:
        if start is not None:
            motion = high_seat.without_contacts(motion, _seated(motion))
        motion = lock_feet(motion)
    if unfolded is not None and ground is not None:
        return climb(motion, travelled, unfolded, ground)
    heights = route.heights(motion.root[:, [0, 2]], travelled)
    if action == "lie" and "pace" in wanted:
        motion, heights = unhurried(motion, heights, goal)
    motion = replace(motion, root=motion.root + heights[:, None] * np.array([0.0, 1.0, 0.0]))
    return follow(motion, heights, ground)


def _on_object(
    motion: Motion, goal: np.ndarray, front: SeatFront | None, top: RestingTop | None, back: SeatBack | None,
    table: np.ndarray | None, posture: Collection[str], wanted: Collection[str],
) -> Motion:  # fmt: skip
    """Return the motion with the corrections that the object asks for. goal: row of Route.goals."""
    if front is not None:
        if "pelvis" in wanted:
            motion = seated_pelvis.kept_on(motion, goal)
        if "shins" in wanted:
            motion = front.clear_shins(motion, goal, 1.0 - _lift_weight(motion))
        up = np.flatnonzero(~_seated(motion))
        seated = int(up[-1]) + 1 if len(up) else 0
        if back is not None and "leaning" in wanted:
            motion = back.leaned_on(motion, goal, seated)
        if "hands" in wanted:
            motion = hands.rested(motion, goal, seated, posture, top, table)
        if "crossing" in wanted and "legs_crossed" in posture:
            motion = crossing.crossed(motion, goal, seated)
    if top is not None:
        angle = top.back or (HALF_SITTING if "half_sitting" in posture else 0.0)
        if angle and "raised_back" in wanted:
            motion = raise_trunk(motion, goal, angle)
        elif not angle and front is None and "spine" in wanted:
            motion = uncurled(motion)
        if front is None and "hovering" in wanted:
            motion = lowered(motion, top)
        if "limbs" in wanted:
            motion = top.cleared(motion, goal)
            if front is not None:
                motion = high_seat.with_level_thighs(motion, top, _seated(motion))
    return motion


def smoothed(motion: Motion, sigma: float = SMOOTHING) -> Motion:
    """Return the motion without the network's jitter, under a Gaussian over time; sigma in frames."""
    return motion.smoothed(sigma)


def settle_on_goal(motion: Motion, goal: np.ndarray, action: str) -> Motion:
    """Remove the remaining distance and turn to the goal, spread over the last stretch of the route.

    goal: row of Route.goals. A seated pelvis ends on the goal's position, a standing one above it.
    """
    tail = slice(max(0, len(motion) - 15), None)
    end = motion.root[tail].mean(0)
    yaw = float(frames.direction_yaw(goal[3:6]))
    turn = frames.wrap_angle(yaw - _mean_yaw(motion, tail))
    missing = goal[:3] - end
    if action not in SEATED:
        missing[1] = 0.0
    weight = _approach_weight(motion.root)
    # The turn is about the pelvis, so that position and facing can be corrected separately.
    q = rotation.about_y(weight * turn)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rotation.multiply(q, rotations[:, 0])
    lift = weight if motion.interaction_start is None else _lift_weight(motion)
    offset = np.stack([weight * missing[0], lift * missing[1], weight * missing[2]], -1)
    return replace(motion, root=motion.root + offset, rotations=rotations)


def _approach_weight(root: np.ndarray) -> np.ndarray:
    """Return weights (T,) that rise smoothly with the distance walked, 0 before the last stretch, 1 at its end."""
    steps = np.linalg.norm(np.diff(root[:, [0, 2]], axis=0), axis=-1)
    left = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
    left = np.maximum(left - left[max(0, len(left) - 15)], 0.0)
    return smoothstep(1 - left / LAST_STRETCH)


def _lift_weight(motion: Motion) -> np.ndarray:
    """Return weights (T,), 0 while standing and 1 seated, that follow the pelvis on its way down.

    On a stool so high that the pelvis hardly sinks they follow time.
    """
    height = motion.root[:, 1]
    low = height[-15:].mean()
    high = np.percentile(height[: max(motion.interaction_start, 1)], 50)
    if high - low < MIN_SINKING:
        return smoothstep((np.arange(len(motion)) - motion.interaction_start + 15) / PERCHING)
    weight = smoothstep((high - height) / (high - low))
    weight[: max(motion.interaction_start - 15, 0)] = 0
    return weight


def _seated(motion: Motion) -> np.ndarray:
    """Return flags (T,) of frames in which the pelvis is down."""
    return _lift_weight(motion) > SEATED_WEIGHT


def _mean_yaw(motion: Motion, part: slice) -> float:
    """Return the mean facing, radians, in some frames."""
    positions, _ = replace(motion, root=motion.root[part], rotations=motion.rotations[part], contacts=None,
                           actions=None).forward_kinematics()  # fmt: skip
    across = positions[:, 1] - positions[:, 2] + positions[:, 16] - positions[:, 17]
    return float(np.arctan2(-across[:, 2].mean(), across[:, 0].mean()))
