"""Goals for locomotion: random way-points on the path of a captured clip, and places where it stands still."""

from __future__ import annotations

import numpy as np

from ..mocap.clip_files import Clip
from ..mocap.events import headings
from ..mocap.natural import BRISK, pace
from .sequence import ACTION_OF_LABEL, Sequence

REACHED = 0.3  # metres: the distance at which a way-point counts as reached, as at run time
AHEAD = (30, 150)  # frames between setting a way-point and reaching it
STANDING = ("idle", "shift", "other", "stand_up", "get_up")


def goal_at(root: np.ndarray, yaw: np.ndarray, frame: int) -> np.ndarray:
    """Return the goal (6,) on the floor under the pelvis at a frame, facing the heading there."""
    return np.array([root[frame, 0], 0.0, root[frame, 2], np.sin(yaw[frame]), 0.0, np.cos(yaw[frame])])


def way_points(
    root: np.ndarray, yaw: np.ndarray, labels: np.ndarray, start: int, stop: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return goals (stop - start, 6) and action indices for the frames start .. stop - 1 of a motion on foot."""
    goals, actions = np.zeros((stop - start, 6)), np.zeros(stop - start, dtype=int)
    still = np.isin(labels, STANDING)
    t = start
    while t < stop:
        ahead = int(rng.integers(*AHEAD))
        target = min(t + ahead, stop - 1)
        standing = np.flatnonzero(still[t : target + 1])
        if len(standing) and still[min(t + standing[0] + 10, stop - 1)]:
            end, goal = _stand(root, yaw, still, t + standing[0], stop)
            action = 0
        else:
            goal = goal_at(root, yaw, target)
            near = np.linalg.norm(root[t : target + 1, [0, 2]] - goal[[0, 2]], axis=-1) < REACHED
            end = t + max(int(np.argmax(near)), 5)
            gait = [ACTION_OF_LABEL[label] for label in labels[t : target + 1]]
            action = 2 if np.mean(np.array(gait) == 2) > 0.5 else 1
        end = min(max(end, t + 1), stop)
        goals[t - start : end - start], actions[t - start : end - start] = goal, action
        t = end
    return goals, actions


def _stand(
    root: np.ndarray, yaw: np.ndarray, still: np.ndarray, first: int, stop: int
) -> tuple[int, np.ndarray]:
    """Return the frame at which the standing that begins at ``first`` ends, and the goal (6,) in its middle."""
    moving = np.flatnonzero(~still[first:stop])
    last = first + int(moving[0]) if len(moving) else stop
    last = min(last, first + 240)
    return last, goal_at(root, yaw, (first + last - 1) // 2)


def by_way_point(
    goals: np.ndarray,
    actions: np.ndarray,
    root: np.ndarray,
    yaw: np.ndarray,
    down: int,
    rng: np.random.Generator,
) -> None:
    """Insert a way-point before the goal in half of the longer approaches; changes goals (T, 6), actions (T,).

    down: frame at which the interaction begins.
    """
    if down > 75 and rng.random() < 0.5:
        via = int(rng.integers(30, down - 30))
        first = goal_at(root, yaw, via)
        near = np.linalg.norm(root[: via + 1, [0, 2]] - first[[0, 2]], axis=-1) < REACHED
        until = int(np.argmax(near))
        goals[:until], actions[:until] = first, 1


def walk_sequence(clip: Clip, rng: np.random.Generator) -> Sequence:
    """Return a clip of locomotion or standing as a sequence with goals on its path."""
    yaw = headings(clip.root, clip.rotations)
    goal, action = way_points(clip.root, yaw, clip.labels, 0, len(clip), rng)
    share = {label: np.mean(clip.labels == label) for label in ("run", "walk")}
    kind = "run" if share["run"] > 0.3 else "walk" if share["walk"] > 0.35 else "idle"
    if kind == "walk" and pace(clip) < BRISK:
        kind = "stroll"
    still = np.isin(clip.labels, STANDING)
    return Sequence(
        kind, clip.root, clip.rotations, clip.labels, clip.feet, clip.bad, goal, action,
        open_start=not still[:5].all(), open_end=not still[-5:].all(),
    )  # fmt: skip
