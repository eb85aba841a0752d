"""Follow: after a goal, a target or a way-point was dragged, its take is made again from where that first matters."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames
from ...errors import SampError
from ...frames import ground_lengths
from ...motion import Motion
from ...pipeline.driver import Toolbox
from ..actions import keyframes, notes
from ..overlays import waypoints
from ..thread_run import ThreadRun
from . import origin, redo
from .origin import Origin
from .redo import Redone

SUFFIX = " followed"
SAME = 0.01
"""Metres by which a place has to be moved."""

PARTED = 0.15
"""Metres between the old and the new way from which the difference matters."""

AHEAD = 0.7
"""Metres before that place at which the new end begins: a walk turns gradually."""

APPROACH = 1.5
"""Metres of the way to a goal that are always new."""


@dataclass(frozen=True)
class Change:
    """What was moved: its name, by how many metres, its step, and for a way-point its number, else None."""

    name: str
    distance: float
    step: int
    waypoint: int | None = None


def run(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    action: bpy.types.Action,
    tools: Toolbox | None = None,
) -> Redone:
    """Make a take again from the frame in which what was moved since first matters, as a new Action.

    Raise SampError where nothing was moved, and what `redo.run` raises.
    """
    frame, seed = first_frame(context, owner, action)
    return redo.run(context, owner, action, frame, seed, tools, _suffix(action))


def begin(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    action: bpy.types.Action,
    tools: Toolbox | None = None,
) -> ThreadRun:
    """Start `run` in a thread."""
    frame, seed = first_frame(context, owner, action)
    return redo.begin(context, owner, action, frame, seed, tools, _suffix(action))


def first_frame(
    context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action
) -> tuple[int, int]:
    """Return the last frame of a take that can stay, and its seed. Raise SampError where nothing was moved."""
    made = origin.read(action)
    found = changes(context, made)
    if not found:
        raise SampError(
            f"Nothing that '{action.name}' depends on was moved; drag its target, a goal or a way-point."
        )
    first = round(action.frame_range[0])
    whole = keyframes.read_motion(owner, action, first, notes.take_end(action), context.scene)
    return first + min(_begins(made, whole, change, first) for change in found), made.job.seed


def changes(context: bpy.types.Context, made: Origin) -> list[Change]:
    """Return what was moved since a take was made: way-points, goal arrows and targets."""
    context.view_layer.update()  # matrices are stale after a script moved something
    found = []
    now = [frames.to_blender(place) for place in waypoints.positions(context)]
    if len(now) == len(made.via):
        away = [float(np.linalg.norm(a - b)) for a, b in zip(now, made.via, strict=True)]
        found += [Change(f"Way-point {k + 1}", d, 0, k) for k, d in enumerate(away) if d > SAME]
    targets, arrows = origin.places(context, made.job)
    for number, step in enumerate(made.job.steps):
        moved = _moved(made.targets[number], targets[number])
        shared = made.arrows[number].keys() & arrows[number].keys()
        moved = max([moved, *(_moved(made.arrows[number][name], arrows[number][name]) for name in shared)])
        if moved > SAME:
            found.append(Change(step.target, moved, number))
    return found


def _moved(before: np.ndarray | None, now: np.ndarray | None) -> float:
    """Return by how many metres a point half a metre from an object's origin moved at most."""
    if before is None or now is None:
        return 0.0
    turned = now[:3, :3] @ np.linalg.pinv(before[:3, :3])
    angle = np.arccos(np.clip((np.trace(turned) - 1) / 2, -1, 1))
    return float(np.linalg.norm(now[:3, 3] - before[:3, 3]) + 0.5 * angle)


def _begins(made: Origin, whole: Motion, change: Change, first: int) -> int:
    """Return the frame index of the last frame that a change leaves as it is."""
    begin = 0 if change.step == 0 else made.ends[change.step - 1] - first
    end = min(made.ends[change.step] - first, len(whole) - 1)
    passing = redo.passing(made, whole) if change.step == 0 else []
    if change.waypoint is None:
        begin = passing[-1] if passing else begin
    else:
        begin, end = ([begin, *passing][change.waypoint], passing[change.waypoint])
    way = ground_lengths(whole.root[begin : end + 1])
    parted = way[-1] * min(1.0, PARTED / change.distance) - AHEAD
    if change.waypoint is None:
        parted = min(parted, way[-1] - APPROACH)
    return begin + int(np.searchsorted(way, max(parted, 0.0), side="right")) - 1


def _suffix(action: bpy.types.Action) -> str:
    """Return what is added to the name of the new Action; nothing more after the first time."""
    return "" if SUFFIX in action.name else SUFFIX
