"""Label each frame of a clip by its name, the pelvis' height and speed, and foot contact; flag frames with pops."""

from __future__ import annotations

import re

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...samp_addon import skeleton
from ...samp_addon.motion import Motion
from ...samp_addon.refine.runs import runs
from .feet import flat_speed

LABELS = (
    "other", "idle", "shift", "walk", "run", "sit_down", "sit", "stand_up", "lie_down", "lie", "get_up",
)  # fmt: skip
STAND = 0.94  # height (m) of the pelvis over the floor, standing
LOWER, HIGHER = 0.14, 0.09  # metres below and above it from which a body crouches or jumps
STANDS = 0.05  # metres below it within which a body counts as standing, before and after a rest
SETTLED = 0.03  # metres by which the pelvis may leave its resting height while seated
SHIFT, WALK, RUN, JOG = 0.12, 0.30, 2.3, 1.1  # m/s of the pelvis
PLANTED = 0.385  # share of frames in contact, per foot, below which motion is a jog; walking is over 0.41
STEP, TURN = 0.22, 0.5  # speed (m/s) of an ankle and yaw rate (rad/s) of the pelvis from which a body shifts
SEATED_SPEED, THIGHS = 0.25, np.cos(np.radians(45.0))  # m/s; cosine between a seated thigh and the vertical
TRUNK_UP, TRUNK_LAID = 0.5, 0.4  # cosine between trunk and vertical while sitting, and while lying
LYING = 0.45  # height (m) over the floor below which the pelvis of a lying body is
SITS = re.compile(r"\b(sit|sits|sitting|seated|seat|chair|stool|sofa|couch|stand up|stand_up)\b")
RUNS = re.compile(r"run|jog|sprint")
WALKS = re.compile(r"walk|stroll|step|turn")
POP, POPS_ALL = 140.0, 220.0  # acceleration (m/s^2) of a pop: of several joints, and of any single one
ENDS = 0.18  # share of a clip at either end within which frames with pops are cut off


def words(text: str) -> str:
    """Return a file's name as lower-case words."""
    text = re.sub(r"(?<=[a-z])(?=[A-Z0-9])|[_\W]+", " ", text)
    return re.sub(r"\s+", " ", text).strip().lower()


def labelled(motion: Motion, contact: np.ndarray, text: str) -> np.ndarray:
    """Return labels (T,) of a motion. contact: (T, 4) flags. text: the clip's name or description."""
    found = _on_foot(motion, contact)
    text = words(text)
    if WALKS.search(text) and not RUNS.search(text):
        found[found == "run"] = "walk"
    if SITS.search(text):
        _mark_rests(found, motion, _seated(motion), ("sit_down", "sit", "stand_up"))
    _mark_rests(found, motion, lying(motion), ("lie_down", "lie", "get_up"))
    return found


def lying(motion: Motion) -> np.ndarray:
    """Flag frames (T,) in which the body lies on the floor, for at least two thirds of a
    second."""
    return _lasting((motion.root[:, 1] < LYING) & (np.abs(trunk_up(motion)) < TRUNK_LAID), motion.fps)


def trunk_up(motion: Motion) -> np.ndarray:
    """Return the cosine (T,) between the trunk, pelvis to neck, and the vertical."""
    positions, _ = motion.forward_kinematics()
    trunk = positions[:, skeleton.INDEX["neck"]] - positions[:, 0]
    return trunk[:, 1] / np.maximum(np.linalg.norm(trunk, axis=-1), 1e-9)


def _on_foot(motion: Motion, contact: np.ndarray) -> np.ndarray:
    """Return labels (T,) by speed alone; frames far from standing height are "other"."""
    positions, globals_ = motion.forward_kinematics()
    even = lambda x, k=15: uniform_filter1d(x, min(k, 2 * (len(x) // 2) + 1), mode="nearest")
    speed = even(flat_speed(motion.root, motion.fps))
    ankles = flat_speed(positions[:, [skeleton.INDEX[f"{s}_ankle"] for s in ("left", "right")]], motion.fps)
    steps = np.maximum(even(ankles[:, 0]), even(ankles[:, 1]))
    facing = positions[:, skeleton.INDEX["left_hip"]] - positions[:, skeleton.INDEX["right_hip"]]
    yaw = np.unwrap(np.arctan2(-facing[:, 2], facing[:, 0]))
    turning = even(np.abs(np.gradient(yaw))) * motion.fps if len(yaw) > 1 else np.zeros(1)
    planted = even(np.stack([contact[:, :2].any(1), contact[:, 2:].any(1)], 1).mean(1), 31)
    steady = even(speed, 21)
    height = motion.root[:, 1]
    found = np.full(len(motion), "idle", dtype="<U9")
    for name, mask, shortest, gap in (
        ("shift", (speed > SHIFT) | (steps > STEP) | ((turning > TURN) & (steps > 0.1)), 6, 8),
        ("walk", speed > WALK, 8, 6),
        ("run", (steady > RUN) | ((steady > JOG) & (planted < PLANTED)), 10, 12),
    ):
        for start, stop in runs(mask, shortest, gap):
            found[start:stop] = name
    low = (height < STAND - LOWER) & ((found != "run") | (height < STAND - 0.25))
    for start, stop in runs(low | (height > STAND + HIGHER), 4, 8):
        found[start:stop] = "other"
    return found


def _seated(motion: Motion) -> np.ndarray:
    """Flag frames (T,) in which the pelvis rests low, with an upright trunk and raised thighs."""
    positions, _ = motion.forward_kinematics()
    thighs = []
    for side in ("left", "right"):
        thigh = positions[:, skeleton.INDEX[f"{side}_hip"]] - positions[:, skeleton.INDEX[f"{side}_knee"]]
        thighs.append(thigh[:, 1] / np.linalg.norm(thigh, axis=-1))
    velocity = np.gradient(motion.root, 1 / motion.fps, axis=0) if len(motion) > 1 else motion.root * 0
    still = uniform_filter1d(np.linalg.norm(velocity, axis=-1), 5, mode="nearest") < SEATED_SPEED
    low = (motion.root[:, 1] < STAND - LOWER) & (np.mean(thighs, axis=0) < THIGHS)
    return _lasting(low & still & (trunk_up(motion) > TRUNK_UP), motion.fps)


def _lasting(mask: np.ndarray, fps: float) -> np.ndarray:
    result = np.zeros(len(mask), bool)
    for start, stop in runs(mask, round(fps * 2 / 3), round(fps / 3)):
        result[start:stop] = True
    return result


def _mark_rests(found: np.ndarray, motion: Motion, rests: np.ndarray, names: tuple[str, str, str]) -> None:
    """Write the labels of descending, resting and getting up into found (T,), for each run of rest.

    A rest lasts while the pelvis is near its resting height. The descent begins after the last standing frame before
    it, and getting up lasts until the body stands again. Clips may begin or end with a rest.
    """
    height = uniform_filter1d(motion.root[:, 1], 5, mode="nearest")
    stood = height > STAND - STANDS
    resting = runs(rests, 1, 0)
    for k, run in enumerate(resting):
        near = np.abs(height - np.median(height[slice(*run)])) < SETTLED
        before = resting[k - 1][1] if k else 0
        after = resting[k + 1][0] if k + 1 < len(resting) else len(found)
        start, stop = _grown(near, *run, before, after)
        found[start:stop] = names[1]
        down = np.flatnonzero(stood[before:start])
        if len(down):
            found[before + down[-1] + 1 : start] = names[0]
        up = np.flatnonzero(stood[stop:after])
        if len(up):
            found[stop : stop + up[0]] = names[2]


def _grown(near: np.ndarray, start: int, stop: int, before: int, after: int) -> tuple[int, int]:
    """Extend a run of frames by adjacent ones near its level, between the frames before and after."""
    while start > before and near[start - 1]:
        start -= 1
    while stop < after and near[stop]:
        stop += 1
    return start, stop


def pops(motion: Motion) -> np.ndarray:
    """Flag frames (T,) around pops: several joints accelerate at once more than a body can."""
    flags = np.zeros(len(motion), bool)
    if len(motion) < 4:
        return flags
    positions, _ = motion.forward_kinematics()
    second = np.linalg.norm(np.diff(positions, 2, axis=0), axis=-1) * motion.fps**2
    ordered = np.sort(second, axis=1)
    wild = np.zeros(len(motion), bool)
    wild[1:-1] = np.maximum(ordered[:, -4], 0.55 * ordered[:, -1]) > POP
    for start, stop in runs(wild, 1, 4):
        flags[max(0, start - 2) : stop + 2] = True
    for k in np.flatnonzero(second.max(1) > POPS_ALL):
        flags[max(0, k - 1) : k + 4] = True
    return flags


def sound_part(glitch: np.ndarray) -> slice:
    """Return the frames that remain when pops (T,) near either end are cut off with all frames beyond them."""
    count = len(glitch)
    start, stop = 0, count
    for first, last in runs(glitch, 1, 0):
        if last <= ENDS * count:
            start = max(start, last)
        elif first >= (1 - ENDS) * count:
            stop = min(stop, first)
    return slice(start, stop)
