"""A job from the artist's scene to finished Actions, for the operators and the batch alike.

Three steps: `read` the scene; the driver makes the takes without Blender (pipeline/driver.py, in a thread if wanted);
`write`. Until `write` nothing in the file has changed: a cancelled job leaves nothing behind.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from typing import Literal

import bpy

from ... import frames
from ...body import betas, body_shape, human
from ...errors import SampError
from ...evaluation.obstacles import shared
from ...methods import registry
from ...methods.take import Failure, Take
from ...pipeline import driver
from ...pipeline.beside_others import beside
from ...pipeline.driver import Store, Toolbox, Work
from ...pipeline.job import Job
from ...progress import Progress
from ...scene.geometry import SceneGeometry
from ..actions import keyframes, notes, refine_action
from ..cast import others
from ..character import armature, character, characters, start
from ..edits import hand_targets, origin
from ..overlays import start_marker
from ..rigs import performers
from ..scene import preconditions, read_scene, read_view
from ..sub_goals import arrows
from ..thread_run import Slices, ThreadRun, run_to_completion
from . import continuing, reporting, seen
from .rollback import Rollback

MEASURED_AT_ONCE = min(4, os.cpu_count() or 1)  # takes
A_MOMENT = 0.02  # seconds
LONGEST_NAME = 50  # of an Action, before its seed: Blender's own limit is 63

StartFrom = Literal["STANDING", "MARKER", "POSE"]


@dataclass(frozen=True)
class Plan:
    """A job read from the scene. geometry: of all furniture, for the measures. owner: the armature that gets the
    takes; None to make the default human. frame_start: of the takes. marked: whether the character gets a start marker
    if it has none. name: of a new character."""

    work: Work
    geometry: SceneGeometry
    owner: bpy.types.Object | None
    frame_start: int
    marked: bool = False
    name: str = "Human"


@dataclass(frozen=True)
class Result:
    """What a job made. variants: the report's entries. actions: of the takes, in the same order."""

    owner: bpy.types.Object
    actions: list[bpy.types.Action]
    variants: list[dict]
    failures: list[Failure]

    @property
    def takes(self) -> dict[bpy.types.Object, list[bpy.types.Action]]:
        """The new Actions of the character."""
        return {self.owner: self.actions}


def run(
    context: bpy.types.Context,
    job: Job,
    progress: Progress = lambda stage, share: None,
    tools: Toolbox | None = None,
    new_character: bool = False,
    store: Store | None = None,
    on_take: Callable[[Take], None] = lambda take: None,
    start_from: StartFrom = "STANDING",
) -> Result:
    """Do the whole job. Raise SampError if not one take can be made, and whatever progress raises.

    new_character, start_from: see `read`. store, on_take: see driver.run.
    """
    plan = read(context, job, new_character, start_from)
    takes, failures = driver.run(plan.work, progress, tools, store, on_take)
    return write(context, plan, takes, failures, progress)


def begin(
    context: bpy.types.Context,
    job: Job,
    tools: Toolbox | None = None,
    start_from: StartFrom = "STANDING",
) -> ThreadRun:
    """Start the job in a thread beside Blender's window, to be finished into a Result. Raise SampError where it cannot
    be done. start_from: see `read`."""
    plan = read(context, job, start_from=start_from)
    return ThreadRun(
        lambda progress: driver.run(plan.work, progress, tools),
        lambda context, made: in_slices(context, plan, *made),
        plan.owner,
    )


def read(
    context: bpy.types.Context, job: Job, new_character: bool = False, start_from: StartFrom = "STANDING"
) -> Plan:
    """Return all that the job needs of the scene.

    new_character: if none is named, make one even if one is there. start_from: where a job without a start of its own
    begins: where the character stands now, at its start marker, or in its current pose at the current frame. Other
    bodies, also those of armatures of other origin that an Action moves, keep their places and their ways.
    """
    owner = owner_of(context, job, new_character)
    if owner is not None and job.shape:
        if new_character:
            raise SampError(f"'{owner.name}' has a shape already, and the sub-goals; leave out --shape.")
        job = replace(job, shape={})
    if job.hand:
        performers.require_smplx(owner, "a hand on something")
    people = characters.people(context)
    people += [owner] if owner is not None and owner not in people else []
    people += others.moving(context, people, (owner,))
    geometry = read_scene.read_scene(context, people)
    before = None
    if owner is not None and job.start is None and start_from == "POSE":
        performers.require_smplx(owner, "Start from Pose")
        before = continuing.read(context, owner)
    elif start_from == "MARKER":
        job = start_marker.at_marker(context, job, owner)
    begin_at = read_view.start_of(job.start, owner) if before is None else before.place
    targets = [context.scene.objects.get(step.target) for step in job.steps if step.target]
    seen.require_still(context, owner, [obj for obj in targets if obj is not None])
    views = [
        read_view.read_view(context, step, geometry, begin_at, people, number == 0, owner)
        for number, step in enumerate(job.steps)
    ]
    preconditions.check(context, owner, views)
    shapes = body_shape.shapes(job.shape) if owner is None else performers.shapes_of(owner)
    body = human.load().shaped(shapes) if owner is None else performers.body_of(owner)
    views = [replace(view, betas=betas.from_named(shapes)) for view in views]
    work = Work(job, continuing.views_after(views, before, job.seeds), body=body, pose=before and before.pose)
    if job.refine:
        work = replace(work, surroundings=refine_action.surroundings(context, geometry))
    first = context.scene.frame_start if before is None else before.frame
    work = beside(work, others.present(context, people, (owner,), first))
    return Plan(work, geometry, owner, first, start_from != "STANDING")


def write(
    context: bpy.types.Context,
    plan: Plan,
    takes: Sequence[Take],
    failures: Sequence[Failure],
    progress: Progress = lambda stage, share: None,
) -> Result:
    """Write a new Action for each take, the first one active; return it with the report's entries.

    If anything goes wrong, what was made is removed again. Raise SampError where there is no take.
    """
    return run_to_completion(in_slices(context, plan, takes, failures), progress)


def in_slices(
    context: bpy.types.Context,
    plan: Plan,
    takes: Sequence[Take],
    failures: Sequence[Failure],
    whole: Rollback | None = None,
) -> Slices:
    """Do `write` a take at a time; closed before its end, it removes what it made.

    whole: the rollback of more work that this is a part of, whose end makes the first take active.
    """
    if not takes:
        raise SampError(failures[0].message if failures else "There is no take; ask for at least one.")
    preconditions.check_writable(context, plan.owner)
    rollback = whole or Rollback(context)
    written, variants = [], []
    obstacles, measured = shared(plan.geometry.triangles), []
    pool = ThreadPoolExecutor(MEASURED_AT_ONCE)  # measured in threads while Blender reads the next take
    try:
        with rollback.recording():
            owner = plan.owner or _new_character(context, takes[0], plan)
        body = performers.body_of(owner)
        for count, take in enumerate(takes):
            yield "Writing keyframes", count / len(takes)
            with rollback.recording():
                motion, hands, missed = hand_targets.applied(
                    context, owner, take.motion, plan.work.job.hand, plan.frame_start
                )
                action, inexact = performers.write(
                    context, owner, motion, _name(plan.work.job, take), plan.frame_start
                )
            written.append(action)
            if take.goal is not None:
                notes.write_goal(action, take.goal)
            via = plan.work.views[0].via if plan.work.views else ()
            origin.write(context, action, plan.work.job, take, via, plan.frame_start)
            notes.write_ground(action, take.laid_ground)
            if hands:
                notes.write_hands(action, hands, plan.frame_start)
            shown, off = performers.shown(context, owner, action, motion)
            remarked = replace(take, remarks=(*take.remarks, *missed, *inexact, *off))
            measured.append(pool.submit(reporting.measured, shown, remarked, obstacles, body))
        for count, (take, action) in enumerate(zip(takes, written, strict=True)):
            while not wait(measured[count : count + 1], A_MOMENT).done:
                yield "Measuring", count / len(takes)
            numbers = measured[count].result()
            variants.append(reporting.entry(context, plan.work.job, take, action, owner, numbers))
            before = None if take.refined is None else take.refined.before
            notes.write_measures(action, numbers.numbers, before)
            notes.write_warnings(action, numbers.warnings)
    except BaseException:
        rollback()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
    if plan.marked and (plan.owner is None or start.stored(owner) is None):
        start_marker.show(context, owner)
    if whole is None:
        keyframes.activate_action(owner, written[0])
    return Result(owner, written, variants, list(failures))


def sentence(result: Result) -> str:
    """Return the sentence that is reported after a job."""
    names = ", ".join(f"'{variant['action_name']}'" for variant in result.variants)
    last = max(variant["frame_end"] for variant in result.variants)
    text = f"Baked {names} onto '{result.owner.name}', up to frame {last}."
    if result.failures:
        text += f" {len(result.failures)} failed: {result.failures[0].message}"
    left = max(
        (variant["refined"]["unsolved_cm"] for variant in result.variants if "refined" in variant), default=0
    )
    if left > refine_action.UNSOLVED * 100:
        text += f" The body is still {left:.0f} cm deep in the scene somewhere."
    doubtful = [variant for variant in result.variants if variant["warnings"]]
    if doubtful:
        text += f" {len(doubtful)} with warnings: {doubtful[0]['warnings'][0]}"
    return text


def owner_of(context: bpy.types.Context, job: Job, new_character: bool) -> bpy.types.Object | None:
    """Return the armature that gets a job's takes, None where one is to be made; see `read`. Raise SampError."""
    if job.character:
        return performers.find(context, job.character)
    if any(read_view.passes_stored(step) for step in job.steps) and (found := arrows.owners(context)):
        return _only(context, found)
    if new_character or not any(armature.is_smplx(obj) for obj in context.scene.objects):
        return None
    selected = [obj for obj in context.selected_objects if armature.is_smplx(obj)]
    return selected[0] if len(selected) == 1 else armature.find(context)


def _only(context: bpy.types.Context, owners: Sequence[bpy.types.Object]) -> bpy.types.Object:
    """Return the only character with sub-goals, or the selected one. Raise SampError where it is not clear."""
    selected = [obj for obj in owners if obj.select_get()]
    if len(owners) > 1 and len(selected) != 1:
        names = ", ".join(f"'{obj.name}'" for obj in owners)
        raise SampError(f"Several characters have sub-goals ({names}); name one of them.")
    return selected[0] if len(selected) == 1 else owners[0]


def _new_character(context: bpy.types.Context, take: Take, plan: Plan) -> bpy.types.Object:
    """Create the default human, in the job's shape, where the take starts."""
    facing = take.motion.headings()[0]
    location = frames.to_blender(take.floor_start)
    return character.create_character(
        context,
        body_shape.shapes(plan.work.job.shape),
        location=tuple(location),
        yaw=float(frames.direction_yaw(facing)),
        name=plan.name,
    )


def _name(job: Job, take: Take) -> str:
    """Return a new name for a take's Action: what it does and on what, its seed, and a count where that is taken."""
    words = [" ".join(word for word in (step.action, step.target) if word) for step in job.steps]
    text = ", ".join(word for word in words if word) or registry.find(take.method).label
    name = f"{text[:LONGEST_NAME]} {take.seed}"
    again = (f"{name} ({count})" for count in itertools.count(2))
    return name if name not in bpy.data.actions else next(n for n in again if n not in bpy.data.actions)
