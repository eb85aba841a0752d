"""One cycle of a walk, or of standing or sitting, that repeats without a jump. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .. import rotation
from ..easing import smoothstep
from ..errors import SampError
from ..frames import wrap_angle
from ..motion import Motion

SHORTEST, LONGEST = 0.8, 3.0
"""Seconds of a cycle."""

FADE = 0.3
"""Seconds at the end of a cycle over which it is blended into its beginning."""

WALKING = 0.35
"""Metres per second of the pelvis from which a body walks; a walk is repeated between two moments of walking."""

WORST = 0.06
"""Metres, mean over the joints, between beginning and end of a cycle beyond which there is none in a take."""

SPEED_WEIGHT = 0.12
"""Seconds: weight of the joints' velocities beside their places."""


@dataclass(frozen=True)
class Loop:
    """A cycle. motion: its last frame is its first one, moved on. advance: (3,) from the first to the last frame,
    metres; zero in place. first, last: frames of the take. gap: metres, mean over the joints, that the blend closes."""

    motion: Motion
    advance: np.ndarray
    first: int
    last: int
    gap: float


def looped(motion: Motion, in_place: bool = False) -> Loop:
    """Cut the cycle that closes best out of a take, walking if it walks anywhere.

    in_place: the pelvis stays over one place; the feet then slide as on a treadmill. Raises SampError where nothing in
    the take repeats.
    """
    first, last, gap = _best_cycle(motion)
    part = motion.at_frames(np.arange(first, last + 1))
    part = replace(part, interaction_start=None)
    root, rotations = _straightened(part.root, part.rotations)
    advance = (root[-1] - root[0]) * [1.0, 0.0, 1.0]
    before = max(first - int(round(FADE * motion.fps)), 0)
    lead = first - before
    if lead:
        # What leads to the beginning, moved on by one cycle, takes over at the end.
        own = slice(before, first + 1)
        pre_root, pre = _moved_onto(motion.root[own], motion.rotations[own], root[-1], root[0], rotations[0])
        share = smoothstep(np.arange(lead + 1) / lead)[:, None]
        rows = slice(len(root) - lead - 1, None)
        root[rows] += share * (pre_root - root[rows])
        rotations[rows] = rotation.slerp(rotations[rows], pre, share)
    root[-1], rotations[-1] = root[0] + advance, rotations[0]
    if in_place:
        root -= np.linspace(0, 1, len(root))[:, None] * advance
        advance = np.zeros(3)
    return Loop(replace(part, root=root, rotations=rotations), advance, first, last, gap)


def _best_cycle(motion: Motion) -> tuple[int, int, float]:
    """Return the first and last frame of the cycle that closes best, and its gap."""
    features, heading, walks = _features(motion)
    if walks.any():
        usable = np.flatnonzero(walks)
    else:
        usable = np.arange(len(motion))
    shortest, longest = (int(round(seconds * motion.fps)) for seconds in (SHORTEST, LONGEST))
    best: tuple[float, int, int] | None = None
    for first in usable:
        lasts = usable[(usable >= first + shortest) & (usable <= first + longest)]
        if not len(lasts):
            continue
        gap = np.linalg.norm(features[lasts] - features[first], axis=-1).mean(-1)
        gap = gap + 0.1 * np.abs(wrap_angle(heading[lasts] - heading[first]))
        k = int(gap.argmin())
        if best is None or gap[k] < best[0]:
            best = float(gap[k]), int(first), int(lasts[k])
    if best is None or best[0] > WORST:
        raise SampError(
            "Nothing in this take repeats; choose one with a longer straight walk or a longer hold."
        )
    return best[1], best[2], best[0]


def _features(motion: Motion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return joints and their weighted velocities (T, 2 J, 3) in the body's frame, headings (T,), radians, and flags
    (T,) of walking."""
    joints = motion.forward_kinematics()[0][:, :22]
    facing = motion.headings()
    yaw = np.arctan2(facing[:, 0], facing[:, 2])
    speed = np.gradient(joints, 1 / motion.fps, axis=0) if len(joints) > 1 else np.zeros_like(joints)
    turn = rotation.about_y(-yaw)[:, None]
    away = joints - motion.root[:, None] * [1.0, 0.0, 1.0]
    both = np.concatenate([away, SPEED_WEIGHT * speed], 1)
    local = rotation.rotate(np.broadcast_to(turn, (*both.shape[:2], 4)), both)
    walks = np.hypot(speed[:, 0, 0], speed[:, 0, 2]) > WALKING
    return local, yaw, walks


def _straightened(root: np.ndarray, rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turn a cycle gradually so that it ends with the heading of its beginning; repeated, it goes on straight."""
    turn = wrap_angle(_yaw(rotations[0]) - _yaw(rotations[-1]))
    back = rotation.about_y(np.linspace(0.0, 1.0, len(root)) * float(turn))
    steps = np.diff(root, axis=0, prepend=root[:1])
    root = root[0] + np.cumsum(rotation.rotate(back, steps), axis=0)
    rotations = rotations.copy()
    rotations[:, 0] = rotation.multiply(back, rotations[:, 0])
    return root, rotations


def _moved_onto(
    root: np.ndarray, rotations: np.ndarray, place: np.ndarray, start: np.ndarray, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Move frames that end at the beginning of a cycle, ``start`` and ``first``, to its end at ``place`` (3,)."""
    turn = rotation.about_y(np.array([float(wrap_angle(_yaw(first) - _yaw(rotations[-1])))]))
    away = rotation.rotate(np.repeat(turn, len(root), 0), root - root[-1])
    moved = rotations.copy()
    moved[:, 0] = rotation.multiply(np.repeat(turn, len(root), 0), rotations[:, 0])
    end = np.array([place[0], start[1], place[2]])
    return end + away, moved


def _yaw(pose: np.ndarray) -> float:
    """Heading of a pose's pelvis, radians. pose: (J, 4)."""
    ahead = rotation.rotate(pose[:1], np.array([[0.0, 0.0, 1.0]]))[0]
    return float(np.arctan2(ahead[0], ahead[2]))
