"""Measures of captured, held-out motion, as a reference for takes."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...samp_addon.evaluation import diversity, feet, metrics, posture
from ...samp_addon.motion import Goal, Motion
from ..look import load_motion
from ..mocap import clip_files
from ..mocap.events import label_runs, sit_events
from .takes import Results

LABELS = {
    "sit": ("sit", "sit_down"),
    "walk": ("walk",),
    "run": ("run",),
    "lie": ("lie", "lie_down", "get_up"),
}
LEAST_SHARE = 0.3  # least share of a clip's frames with the action
GOING = {"walk": 0.5, "run": 1.2}  # speed (m/s) above which a body walks or runs
LEAST_FRAMES = 10


def real_motion(folder: Path, action: str) -> list[Motion]:
    """Return the test clips of an action, by their labels; none where the folder is missing."""
    found = []
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as data:
            labels = data["label_names"][data["label"]]
        if np.isin(labels, LABELS[action]).mean() > LEAST_SHARE:
            found.append(load_motion(path))
    return found


def spell(motion: Motion, action: str) -> Motion:
    """Return the longest run of frames faster than GOING in a walk or run; the whole motion of other actions."""
    if action not in GOING:
        return motion
    speed = np.linalg.norm(np.gradient(motion.root[:, [0, 2]], 1 / motion.fps, axis=0), axis=-1)
    runs = [(b - a, a, b) for name, a, b in label_runs(speed > GOING[action]) if name == "True"]
    length, start, stop = max(runs, default=(0, 0, 0))
    part = slice(start, stop) if length >= LEAST_FRAMES else slice(None)
    return replace(
        motion, root=motion.root[part], rotations=motion.rotations[part], contacts=None, actions=None,
        interaction_start=None,
    )  # fmt: skip


def measures(real: Sequence[Motion], action: str) -> dict[str, float]:
    """Return the means over captured clips of feet, jerk and posture, and the APD of all clips."""
    measured = [
        feet.measures(motion, 0.0) | {"jerk_m_s3": metrics.jerk(motion)} | posture.measures(motion)
        for motion in real
    ]
    found = {}
    for key in sorted(set().union(*measured)):
        values = [one[key] for one in measured if one.get(key) is not None]
        if values:
            found[key] = statistics.mean(values)
    if real:
        found["APD"] = diversity.diversity([spell(motion, action) for motion in real])
    return found


def real_pace(folders: Sequence[Path]) -> tuple[float, float] | None:
    """Return the time of captured people to walk to a seat and sit still: seconds, and seconds per metre.

    They are fitted linearly to all captured sits of the folders; None where there are fewer than ten.
    """
    ways, times = [], []
    for clip in (clip for folder in folders if folder.exists() for clip in clip_files.load_clips(folder)):
        for event in sit_events(clip):
            part = clip.cut(event.entry, event.seat_end + 1)
            goal = Goal(event.pelvis, np.array([np.sin(event.yaw), 0.0, np.cos(event.yaw)]))
            needed = metrics.execution_time(Motion(part.root, part.rotations), goal)
            if needed is not None:
                before = part.root[: round(needed * clip_files.FPS) + 1, [0, 2]]
                ways.append(np.linalg.norm(np.diff(before, axis=0), axis=-1).sum())
                times.append(needed)
    if len(ways) < 10:
        return None
    slope, start = np.polyfit(ways, times, 1)
    return float(start), float(slope)


def execution_ratios(results: Results, pace: tuple[float, float]) -> list[float]:
    """Return the takes' execution times over those of captured people on paths of the same length."""
    ratios = []
    for take, numbers in zip(results.takes, results.numbers, strict=True):
        way = float(np.linalg.norm(np.diff(take.waypoints[:, [0, 2]], axis=0), axis=-1).sum())
        if numbers["execution_time_s"] is not None:
            ratios.append(numbers["execution_time_s"] / (pace[0] + pace[1] * way))
    return ratios
