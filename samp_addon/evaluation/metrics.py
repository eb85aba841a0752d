"""How well a take reached its goal, and how smoothly: Motion and Goal in, numbers out (SAMP, section 5).

Network frame: metres, Y up, +Z forward. The feet are measured in feet.py, contact and penetration in
collision.py, diversity in diversity.py; `measure` gathers what a report tells of one take.
"""

from __future__ import annotations

import numpy as np

from ..body.human import Human
from ..motion import Goal, Motion
from ..skeleton import BODY_COUNT
from . import collision, feet
from .obstacles import Obstacles

SUCCESS_DISTANCE = 0.20
"""Metres between the pelvis and its goal within which a take has arrived."""

SUCCESS_SECONDS = 1.0
ARRIVED_SPEED = 0.1
"""Metres a second. A slower pelvis within reach of the goal has arrived."""


def _last_second(motion: Motion) -> slice:
    return slice(max(len(motion) - int(round(SUCCESS_SECONDS * motion.fps)) - 1, 0), None)


def success(motion: Motion, goal: Goal) -> bool:
    """Whether the pelvis is within 20 cm of the goal for all of the last second; a shorter take never is."""
    if motion.seconds < SUCCESS_SECONDS - 1e-6:
        return False
    return bool((_distance(motion, goal)[_last_second(motion)] <= SUCCESS_DISTANCE).all())


def position_error(motion: Motion, goal: Goal) -> float:
    """PE: distance in cm between pelvis and goal, mean over the last second."""
    return float(_distance(motion, goal)[_last_second(motion)].mean() * 100)


def rotation_error(motion: Motion, goal: Goal) -> float:
    """RE: angle in degrees between the facing and the goal's direction, mean over the last second."""
    wanted = np.array([goal.direction[0], 0.0, goal.direction[2]])
    wanted = wanted / max(np.linalg.norm(wanted), 1e-9)
    cosine = np.clip(motion.headings()[_last_second(motion)] @ wanted, -1, 1)
    return float(np.degrees(np.arccos(cosine)).mean())


def execution_time(motion: Motion, goal: Goal) -> float | None:
    """Seconds until the pelvis is within 20 cm of the goal and slower than 0.1 m/s; None if it never is."""
    if len(motion) < 2:
        return None
    speed = np.linalg.norm(np.gradient(motion.root, 1 / motion.fps, axis=0), axis=-1)
    arrived = np.flatnonzero((_distance(motion, goal) <= SUCCESS_DISTANCE) & (speed < ARRIVED_SPEED))
    return float(arrived[0] / motion.fps) if len(arrived) else None


def jerk(motion: Motion) -> float:
    """99th percentile of the 22 body joints' jerk, m/s^3; 0 for takes of fewer than 4 frames."""
    if len(motion) < 4:
        return 0.0
    joints = motion.forward_kinematics()[0][:, :BODY_COUNT]
    return float(np.percentile(np.linalg.norm(np.diff(joints, n=3, axis=0), axis=-1) * motion.fps**3, 99))


def goal_measures(motion: Motion, goal: Goal) -> dict[str, float | bool | None]:
    """Success, PE (cm), RE (deg) and execution time (s) of one take."""
    return {
        "success": success(motion, goal),
        "position_error_cm": position_error(motion, goal),
        "rotation_error_deg": rotation_error(motion, goal),
        "execution_time_s": execution_time(motion, goal),
    }


def measure(
    motion: Motion,
    goal: Goal | None = None,
    obstacles: Obstacles | None = None,
    floor: float = 0.0,
    body: Human | None = None,
) -> dict[str, float | bool | None]:
    """All measures of one take, ready for a report: plain numbers.

    goal: None where the take has none. obstacles: of the scene, if that is measured; takes that share them cost
    less. floor: height in metres on which the feet stand, and under which all is solid. body: whose skin is measured;
    the default human if left out.
    """
    numbers = {} if goal is None else goal_measures(motion, goal)
    numbers["jerk_m_s3"] = jerk(motion)
    numbers.update(feet.measures(motion, floor, body))
    if obstacles is not None:
        numbers.update(collision.measures(motion, obstacles, floor, body=body))
    return numbers


def _distance(motion: Motion, goal: Goal) -> np.ndarray:
    return np.linalg.norm(motion.root - np.asarray(goal.position), axis=-1)
