"""A job from the artist's scene to finished Actions, for the operators and the batch alike.

Three steps: ``read`` the scene, synthesise without Blender (synthesis/chain.py, in a thread if wanted),
``write``. Until ``write`` nothing in the file has changed: a job that is cancelled leaves nothing behind.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ... import frames
from ...body import human
from ...body.human import Human
from ...errors import SampError
from ...evaluation import metrics
from ...evaluation.obstacles import Obstacles
from ...methods.take import Failure, Situation, Take
from ...pipeline import chain
from ...pipeline.job import Job
from ...pipeline.refine_takes import refine_takes
from ...pipeline.steps import synthesise_steps
from ...progress import Progress
from ...refine.refinement import Surroundings
from ...scene.geometry import SceneGeometry
from ..actions import keyframes, notes, refine_action
from ..character import armature, character
from ..overlays import goal_arrows as arrows
from ..overlays import waypoints
from ..scene import preconditions, read_scene
from ..thread_run import Slices, ThreadRun, in_one_go
from . import reporting

MEASURED_AT_ONCE = min(4, os.cpu_count() or 1)  # takes
A_MOMENT = 0.02  # seconds
LONGEST_NAME = 50  # of an Action, before its seed: Blender's own limit is 63


@dataclass(frozen=True)
class Plan:
    """A job read from the scene: what each of its steps has to know. owner: the armature that gets the takes; None to
    make the default human. surroundings and body: what its takes are refined against and for, if they shall be."""

    job: Job
    situations: list[Situation]
    owner: bpy.types.Object | None
    surroundings: Surroundings | None = None
    body: Human | None = None


@dataclass(frozen=True)
class Result:
    """What a job made. variants: the report's entries. actions: of the takes, in the same order."""

    owner: bpy.types.Object
    actions: list[bpy.types.Action]
    variants: list[dict]
    failures: list[Failure]


def run(
    context: bpy.types.Context,
    job: Job,
    progress: Progress = lambda stage, share: None,
    tools: chain.Tools | None = None,
    new_character: bool = False,
) -> Result:
    """The whole job. Raises SampError if not one take can be made, and whatever progress raises."""
    plan = read(context, job, new_character)
    return write(context, plan, *synthesise(plan, progress, tools), progress)


def begin(context: bpy.types.Context, job: Job, tools: chain.Tools | None = None) -> ThreadRun:
    """The job in a thread beside Blender's window, to be finished into a Result. Raises SampError where it cannot be
    done."""
    plan = read(context, job)
    return ThreadRun(
        lambda progress: synthesise(plan, progress, tools),
        lambda context, made: in_slices(context, plan, *made),
        plan.owner,
    )


def synthesise(
    plan: Plan,
    progress: Progress = lambda stage, share: None,
    tools: chain.Tools | None = None,
) -> tuple[list[Take], list[Failure]]:
    """The plan's takes and what failed; needs no Blender, and may run in a thread of its own."""
    steps = list(zip(plan.job.steps, plan.situations, strict=True))
    takes, failures = synthesise_steps(steps, progress, tools)
    if plan.surroundings is None:
        return takes, failures
    tools = tools or chain.networks()
    takes, unrefined = refine_takes(takes, plan.surroundings, plan.body, tools, progress)
    return takes, [*failures, *unrefined]


def read(context: bpy.types.Context, job: Job, new_character: bool = False) -> Plan:
    """All that the job needs of the scene. new_character: if none is named, make one even if one is there."""
    owner = _owner(context, job, new_character)
    # Characters move: where another one stands now is no obstacle.
    exclude = [obj for obj in context.scene.objects if armature.is_smplx(obj)]
    scene = read_scene.read_scene(context, exclude)
    start = _start(job, owner)
    situations = [_situation(context, step, scene, start, exclude) for step in job.steps]
    via = [frames.to_network(np.array(place)) for place in job.via] or waypoints.positions(context)
    situations[0] = replace(situations[0], via=via)
    preconditions.check(context, owner, situations)
    if not job.refine:
        return Plan(job, situations, owner)
    body = human.load() if owner is None else character.body_of(owner)
    return Plan(job, situations, owner, refine_action.surroundings(context, scene), body)


def _situation(
    context: bpy.types.Context,
    step: Job,
    scene: SceneGeometry,
    start: tuple[np.ndarray, float] | None,
    exclude: Sequence[bpy.types.Object],
) -> Situation:
    """What one step has to know of the scene."""
    target, goals = None, ()
    if step.target:
        target = read_scene.read_target(context, step.target, exclude)
        goals = arrows.read_goals(context, target, step.action)
    return Situation(
        scene=scene,
        target=None if target is None else target.triangles,
        parts=() if target is None else target.parts,
        start=start,
        destination=None if step.to is None else _place(step.to),
        goals=goals,
    )


def write(
    context: bpy.types.Context,
    plan: Plan,
    takes: Sequence[Take],
    failures: Sequence[Failure],
    progress: Progress = lambda stage, share: None,
) -> Result:
    """One new Action for each take, the first one active, and the report.

    If anything goes wrong, what was made is taken away again. Raises SampError where there is no take.
    """
    return in_one_go(in_slices(context, plan, takes, failures), progress)


def in_slices(
    context: bpy.types.Context, plan: Plan, takes: Sequence[Take], failures: Sequence[Failure]
) -> Slices:
    """`write`, a take at a time; closed before its end, it takes away what it made."""
    if not takes:
        raise SampError(failures[0].message if failures else "There is no take; ask for at least one.")
    preconditions.check_writable(context, plan.owner)
    undo = _Undo(context)
    written, variants = [], []
    obstacles, measured = Obstacles(plan.situations[-1].scene.triangles), []
    pool = ThreadPoolExecutor(MEASURED_AT_ONCE)  # beside Blender, which reads the next take meanwhile
    try:
        owner = plan.owner or _new_character(context, takes[0])
        body = character.body_of(owner)
        for count, take in enumerate(takes):
            yield "Writing keyframes", count / len(takes)
            action = keyframes.write_motion(
                owner, take.motion, _name(plan.job, take), context.scene.frame_start, context.scene, False
            )
            written.append(action)
            notes.write_goal(action, take.goal)
            notes.write_ground(action, take.laid_ground)
            shown = keyframes.read_motion(owner, action, scene=context.scene)
            measured.append(pool.submit(reporting.measured, shown, take, obstacles, body))
        for count, (take, action) in enumerate(zip(takes, written, strict=True)):
            while not wait(measured[count : count + 1], A_MOMENT).done:
                yield "Measuring", count / len(takes)
            told = measured[count].result()
            variants.append(reporting.entry(context, plan.job, take, action, owner, told))
            before = None if take.refined is None else take.refined.before
            notes.write_measures(action, told.numbers, before)
    except BaseException:
        undo()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
    keyframes.activate_action(owner, written[0])
    return Result(owner, written, variants, list(failures))


def sentence(result: Result) -> str:
    """What the artist is told of a job that is done."""
    names = ", ".join(f"'{variant['action_name']}'" for variant in result.variants)
    last = max(variant["frame_end"] for variant in result.variants)
    told = f"Baked {names} onto '{result.owner.name}', up to frame {last}."
    if result.failures:
        told += f" {len(result.failures)} failed: {result.failures[0].message}"
    left = max(
        (variant["refined"]["unsolved_cm"] for variant in result.variants if "refined" in variant), default=0
    )
    if left > refine_action.UNSOLVED * 100:
        told += f" The body is still {left:.0f} cm deep in the scene somewhere."
    return told


def _owner(context: bpy.types.Context, job: Job, new_character: bool) -> bpy.types.Object | None:
    if job.character:
        return armature.find(context, job.character)
    if new_character or not any(armature.is_smplx(obj) for obj in context.scene.objects):
        return None
    selected = [obj for obj in context.selected_objects if armature.is_smplx(obj)]
    return selected[0] if len(selected) == 1 else armature.find(context)


def _start(job: Job, owner: bpy.types.Object | None) -> tuple[np.ndarray, float] | None:
    """Floor position and yaw, network frame: as asked for, or where the character stands, or None."""
    if job.start is not None:
        return _place(job.start)
    if owner is None:
        return None
    pelvis, yaw = armature.standing_place(owner)
    rest = armature.calibrate(owner).rest_joints
    return pelvis + [0.0, rest[:, 1].min(), 0.0], yaw


def _place(numbers: Sequence[float]) -> tuple[np.ndarray, float | None]:
    """Position and yaw in radians, network frame, of (x, y, z) or (x, y, z, yaw) in Blender's."""
    yaw = math.radians(numbers[3]) if len(numbers) > 3 else None
    return frames.to_network(np.array(numbers[:3])), yaw


def _new_character(context: bpy.types.Context, take: Take) -> bpy.types.Object:
    """The default human where the take starts."""
    facing = metrics.heading(take.motion)[0]
    location = frames.to_blender(take.waypoints[0])
    return character.create_character(
        context, location=tuple(location), yaw=float(frames.direction_yaw(facing))
    )


def _name(job: Job, take: Take) -> str:
    told = ", ".join(" ".join(part for part in (step.action, step.target) if part) for step in job.steps)
    return f"{told[:LONGEST_NAME]} {take.seed}"


class _Undo:
    """Takes away what was made since, and puts the selection back: for a job that stops half-way."""

    KINDS = ("actions", "objects", "meshes", "armatures", "materials", "collections")

    def __init__(self, context: bpy.types.Context) -> None:
        self.layer = context.view_layer
        self.active = self.layer.objects.active
        self.selected = list(context.selected_objects)
        self.present = {kind: set(getattr(bpy.data, kind)) for kind in self.KINDS}

    def __call__(self) -> None:
        for kind in self.KINDS:
            data = getattr(bpy.data, kind)
            for made in set(data) - self.present[kind]:
                data.remove(made)
        left = set(bpy.data.objects)  # the artist may have deleted something meanwhile
        for thing in self.selected:
            if thing in left:
                thing.select_set(True)
        if self.active is None or self.active in left:
            self.layer.objects.active = self.active
