"""Accuracy and smoothness of a take (SAMP, section 5), and all metrics of a report.

Network frame: metres, Y up, +Z forward. The feet are measured in feet.py, contact and penetration in collision.py,
diversity in diversity.py; `measure` combines the metrics of one take.
"""

from __future__ import annotations

import numpy as np

from ..body import human
from ..body.human import Human
from ..motion import Goal, Motion
from ..skeleton import BODY_COUNT
from . import collision, feet, support
from .obstacles import Obstacles

SUCCESS_DISTANCE = 0.20
"""Metres. Largest distance of the pelvis from the goal of a take that has arrived."""

SUCCESS_SECONDS = 1.0
ARRIVED_SPEED = 0.1
"""Metres per second. Largest speed of the pelvis of a take that has arrived."""


def _last_second(motion: Motion) -> slice:
    """Return the frames of the last second."""
    return slice(max(len(motion) - int(round(SUCCESS_SECONDS * motion.fps)) - 1, 0), None)


def success(motion: Motion, goal: Goal) -> bool:
    """Return whether the pelvis is within 20 cm of the goal during the whole last second; false for shorter takes."""
    if motion.seconds < SUCCESS_SECONDS - 1e-6:
        return False
    return bool((_distance(motion, goal)[_last_second(motion)] <= SUCCESS_DISTANCE).all())


def position_error(motion: Motion, goal: Goal) -> float:
    """Return PE, the distance between pelvis and goal, cm, mean over the last second."""
    return float(_distance(motion, goal)[_last_second(motion)].mean() * 100)


def rotation_error(motion: Motion, goal: Goal) -> float:
    """Return RE, the angle between the facing and the goal's direction, degrees, mean over the last second."""
    wanted = np.array([goal.direction[0], 0.0, goal.direction[2]])
    wanted = wanted / max(np.linalg.norm(wanted), 1e-9)
    cosine = np.clip(motion.headings()[_last_second(motion)] @ wanted, -1, 1)
    return float(np.degrees(np.arccos(cosine)).mean())


def execution_time(motion: Motion, goal: Goal) -> float | None:
    """Return the seconds until the pelvis is within 20 cm of the goal and slower than 0.1 m/s, or None."""
    if len(motion) < 2:
        return None
    speed = np.linalg.norm(np.gradient(motion.root, 1 / motion.fps, axis=0), axis=-1)
    arrived = np.flatnonzero((_distance(motion, goal) <= SUCCESS_DISTANCE) & (speed < ARRIVED_SPEED))
    return float(arrived[0] / motion.fps) if len(arrived) else None


def jerk(motion: Motion) -> float:
    """Return the 99th percentile of the jerk of the 22 body joints, m/s^3; 0 for takes of fewer than 4 frames."""
    if len(motion) < 4:
        return 0.0
    joints = motion.forward_kinematics()[0][:, :BODY_COUNT]
    return float(np.percentile(np.linalg.norm(np.diff(joints, n=3, axis=0), axis=-1) * motion.fps**3, 99))


def goal_measures(motion: Motion, goal: Goal) -> dict[str, float | bool | None]:
    """Compute success, PE (cm), RE (degrees) and execution time (s) of one take."""
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
    """Compute all metrics of one take, as plain numbers for a report.

    goal: without one, its metrics are left out. obstacles: of the scene, without which collisions are left out; cheaper
    if shared by several takes. floor: height on which the feet stand and below which everything is solid, metres. body:
    the default human if left out.
    """
    numbers = {} if goal is None else goal_measures(motion, goal)
    numbers["jerk_m_s3"] = jerk(motion)
    numbers.update(feet.measures(motion, floor, body))
    if obstacles is not None:
        body = body or human.load()
        skin = human.skin(body, motion, body.collision)
        found = obstacles.depth(skin, floor)
        numbers.update(collision.measures(motion, obstacles, floor, body, found))
        numbers.update(support.measures(motion, goal, obstacles, floor, body, found, skin))
    return numbers


def _distance(motion: Motion, goal: Goal) -> np.ndarray:
    """Return the distance (T,) between pelvis and goal, metres."""
    return np.linalg.norm(motion.root - np.asarray(goal.position), axis=-1)
