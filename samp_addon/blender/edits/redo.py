"""Redo From Here: another end for the same beginning of a take."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ... import frames
from ...body import betas, proportions
from ...edits.continuation import continued
from ...errors import SampError
from ...methods.take import Failure, Take
from ...motion import Motion
from ...pipeline import driver
from ...pipeline.driver import Toolbox, Work
from ...pipeline.job import Job
from ..actions import keyframes, notes, refine_action
from ..actions.action_names import derived_name
from ..character import armature, character, characters
from ..overlays import waypoints
from ..scene import preconditions, read_scene, read_view
from ..takes import continuing, seen
from ..thread_run import ThreadRun, one_slice
from . import origin, rewriting
from .origin import Origin

SUFFIX = " redo"
_AGAIN = re.compile(r"^(.*) redo(\.\d{3})?$")
PASSED = 0.6
"""Metres from a way-point within which a walk passes it."""


@dataclass(frozen=True)
class Plan:
    """A new end of a take. frame: the last one that stays. head: the frames of the take up to there."""

    work: Work
    owner: bpy.types.Object
    action: bpy.types.Action
    origin: Origin
    frame: int
    head: Motion
    number: int
    suffix: str


@dataclass(frozen=True)
class Redone:
    """The new Action. frame: the last one that is as before."""

    action: bpy.types.Action
    frame: int

    def sentence(self) -> str:
        """Return what came of it."""
        last = self.action.frame_range[1]
        return f"'{self.action.name}' is new from frame {self.frame + 1} on, up to frame {last:.0f}."


def run(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    action: bpy.types.Action,
    frame: int | None = None,
    seed: int | None = None,
    tools: Toolbox | None = None,
    suffix: str = SUFFIX,
) -> Redone:
    """Make a take again after a frame, by default the current one, as a new Action; the take stays as it is.

    seed: of the new end; by default one more than the take's. Raise SampError where it is not known how the take was
    made, where the frame is not within it, and where the new end cannot be made.
    """
    plan = read(context, owner, action, frame, seed, suffix)
    return write(context, plan, *driver.run(plan.work, tools=tools))


def begin(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    action: bpy.types.Action,
    frame: int | None = None,
    seed: int | None = None,
    tools: Toolbox | None = None,
    suffix: str = SUFFIX,
) -> ThreadRun:
    """Start `run` in a thread, to be finished into what it returns."""
    plan = read(context, owner, action, frame, seed, suffix)
    return ThreadRun(
        lambda progress: driver.run(plan.work, progress, tools),
        lambda context, made: one_slice(lambda: write(context, plan, *made)),
        owner,
    )


def read(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    action: bpy.types.Action,
    frame: int | None = None,
    seed: int | None = None,
    suffix: str = SUFFIX,
) -> Plan:
    """Return what the new end needs of the take and the scene as it is now; see `run`."""
    keyframes.require_editable(owner)
    made = origin.read(action)
    first, last = round(action.frame_range[0]), notes.take_end(action)
    frame = context.scene.frame_current if frame is None else frame
    if not first <= frame < last:
        raise SampError(f"Frame {frame} is not within '{action.name}'; go to one from {first} to {last - 1}.")
    number = made.step_at(frame)
    seed = (made.job.seed + 1) % 2**31 if seed is None else seed
    job = made.job_from(number, seed, owner.name)
    whole = keyframes.read_motion(owner, action, first, last, context.scene)
    head = whole.at_frames(np.arange(frame - first + 1))
    before = continuing.before(owner, head, frame)
    if before.take is None:
        raise SampError(f"'{action.name}' has no notes of its contacts and actions; choose a generated take.")
    work = _work(context, owner, job, before)
    via = _ahead(context, made, whole, frame - first) if number == 0 else []
    views = [replace(work.views[0], via=via), *work.views[1:]]
    return Plan(replace(work, views=views), owner, action, made, frame, head, number, suffix)


def _work(context: bpy.types.Context, owner: bpy.types.Object, job: Job, before: continuing.Before) -> Work:
    """Return the work of a job that goes on from a motion, in the scene as it is now."""
    people = characters.people(context)
    geometry = read_scene.read_scene(context, people)
    targets = [context.scene.objects.get(step.target) for step in job.steps if step.target]
    seen.require_still(context, owner, [obj for obj in targets if obj is not None])
    views = [
        read_view.read_view(context, step, geometry, before.place, people, False, owner) for step in job.steps
    ]
    preconditions.check(context, owner, views)
    shape = betas.from_named(character.shapes_of(owner))
    views = continuing.views_after([replace(view, betas=shape) for view in views], before, job.seeds)
    around = refine_action.surroundings(context, geometry) if job.refine else None
    return Work(job, views, around, character.body_of(owner), before.pose)


def _ahead(context: bpy.types.Context, made: Origin, whole: Motion, frame: int) -> list[np.ndarray]:
    """Return the way-points, where they are now, that the take passes after a frame index; network frame."""
    now = waypoints.positions(context)
    now = now if len(now) == len(made.via) else [frames.to_network(place) for place in made.via]
    return [place for place, passed in zip(now, passing(made, whole), strict=True) if passed > frame]


def passing(made: Origin, whole: Motion) -> list[int]:
    """Return the frame index in which a take passes each of its way-points, rising."""
    found, begin = [], 0
    for place in made.via:
        away = np.linalg.norm((whole.root - frames.to_network(place))[begin:, [0, 2]], axis=-1)
        near = np.flatnonzero(away < max(PASSED, away.min() + 0.05))
        # The first pass: a path may cross the place again later.
        run = near[: np.argmax(np.diff(near, append=near[-1] + 2) > 1) + 1]
        begin += int(run[away[run].argmin()])
        found.append(begin)
    return found


def write(
    context: bpy.types.Context, plan: Plan, takes: Sequence[Take], failures: Sequence[Failure]
) -> Redone:
    """Write the new Action and make it the owner's active one. Raise SampError where there is no take."""
    if not takes:
        raise SampError(failures[0].message if failures else "There is no new end; try another seed.")
    take, owner, action = takes[0], plan.owner, plan.action
    keyframes.require_editable(owner)
    if action not in set(bpy.data.actions):
        raise SampError("The take was deleted meanwhile; start again.")
    rate = keyframes.frames_per_second(context.scene)
    rest = armature.calibrate(owner).rest_joints
    tail = continued(plan.head, proportions.adapt(take.motion, rest).resampled(rate))
    again = _AGAIN.match(action.name) if plan.suffix == SUFFIX else None
    name = again[1] + SUFFIX if again else derived_name(action, plan.suffix)
    new = rewriting.continued(owner, action, plan.frame, tail, name)
    first = plan.frame - len(plan.head) + 1
    notes.write_motion(new, _joined(plan.head, tail), first)
    if take.goal is not None:
        notes.write_goal(new, take.goal)
    _renew(context, plan, new, take, tail)
    if action.library is None:
        action.use_fake_user = True
    keyframes.activate_action(owner, new)
    return Redone(new, plan.frame)


def _joined(head: Motion, tail: Motion) -> Motion:
    """Return what the new Action shows, for its notes; the tail's first frame is the head's last one."""
    rest = replace(tail.at_frames(np.arange(1, len(tail))), interaction_start=None)
    both: Callable = lambda a, b: None if a is None or b is None else np.concatenate([a, b])
    start = tail.interaction_start
    return Motion(
        np.concatenate([head.root, rest.root]),
        np.concatenate([head.rotations[:, :22], rest.rotations[:, :22]]),
        head.fps,
        both(head.contacts, rest.contacts),
        both(head.actions, rest.actions),
        interaction_start=None if start is None else len(head) - 1 + start,
    )


def _renew(context: bpy.types.Context, plan: Plan, new: bpy.types.Action, take: Take, tail: Motion) -> None:
    """Renew the notes that were about the old end."""
    for key in (notes.MEASURES_KEY, notes.BEFORE_KEY, notes.WARNINGS_KEY, notes.STAR_KEY):
        if key in new:
            del new[key]
    first = plan.frame - len(plan.head) + 1
    if notes.HANDS_KEY in new:
        notes.write_hands(new, notes.read_hands(plan.action, first, plan.frame), first)
    notes.write_warnings(new, take.remarks)
    made = plan.origin
    lengths = np.cumsum([len(step.motion) for step in take.steps] or [len(take.motion)]) - 1
    ends = plan.frame + np.round(lengths * (len(tail) - 1) / max(lengths[-1], 1)).astype(int)
    via = made.via
    now = waypoints.positions(context)
    if len(now) == len(via) and len(via):
        via = np.array([frames.to_blender(place) for place in now])
    targets, arrows = origin.places(context, made.job)
    job = replace(made.job, seed=plan.work.job.seed)
    origin.store(new, Origin(job, (*made.ends[: plan.number], *map(int, ends)), via, targets, arrows))
