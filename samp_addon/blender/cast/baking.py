"""A cast from the artist's scene to finished Actions, one for each member and take, for operators and batch alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import bpy

from ...errors import SampError
from ...methods.take import Failure
from ...pipeline.cast import cast_take, directing
from ...pipeline.cast.cast import Cast
from ...pipeline.cast.cast_take import CastTake
from ...pipeline.driver import Store, Toolbox, Work
from ...progress import Progress
from ..actions import keyframes
from ..takes import baking
from ..takes.rollback import Rollback
from ..thread_run import Slices, ThreadRun, run_to_completion
from . import reading, reporting
from .reading import CastPlan


@dataclass(frozen=True)
class CastResult:
    """What a cast made. owners, actions: of the members that have takes, by their numbers; the actions in the order of
    the seeds. variants: the report's entries. failures: what could not be made."""

    owners: dict[int, bpy.types.Object]
    actions: dict[int, dict[int, bpy.types.Action]]
    variants: list[dict]
    failures: list[Failure]

    @property
    def takes(self) -> dict[bpy.types.Object, list[bpy.types.Action]]:
        """The new Actions of each character, in the order of the seeds."""
        return {self.owners[number]: list(own.values()) for number, own in self.actions.items()}


def run(
    context: bpy.types.Context,
    cast: Cast,
    progress: Progress = lambda stage, share: None,
    tools: Toolbox | None = None,
    store: Store | None = None,
    on_take: Callable[[CastTake], None] = lambda take: None,
    from_markers: bool = False,
) -> CastResult:
    """Bake a cast. Raise SampError if not one take can be made, and whatever progress raises."""
    plan = reading.read(context, cast, from_markers)
    takes = directing.run(plan.work, progress, tools, store, on_take)
    return run_to_completion(in_slices(context, plan, takes), progress)


def begin(
    context: bpy.types.Context, cast: Cast, tools: Toolbox | None = None, from_markers: bool = False
) -> ThreadRun:
    """Start a cast in a thread beside Blender's window, to be finished into a CastResult."""
    plan = reading.read(context, cast, from_markers)
    owner = next((owner for owner in plan.owners if owner is not None), None)
    return ThreadRun(
        lambda progress: directing.run(plan.work, progress, tools),
        lambda context, made: in_slices(context, plan, made),
        owner,
    )


def in_slices(context: bpy.types.Context, plan: CastPlan, takes: Sequence[CastTake]) -> Slices:
    """Write a new Action for each take of each member, the first ones active; closed before its end, it removes what
    it made."""
    failures = [failure for take in takes for failure in cast_take.failures(take)]
    if not any(take.takes for take in takes):
        raise SampError(failures[0].message if failures else "The cast has no take.")
    rollback = Rollback(context)
    owners = {number: owner for number, owner in enumerate(plan.owners) if owner is not None}
    actions: dict[int, dict[int, bpy.types.Action]] = {}
    variants = []
    try:
        for take in takes:
            entries = {}
            for number, own in take.takes.items():
                part = _part(plan, take, number, owners.get(number))
                result = yield from baking.in_slices(context, part, [own], [], rollback)
                owners[number] = result.owner
                entries[number] = result.variants[0]
                actions.setdefault(number, {})[take.seed] = result.actions[0]
            if entries:
                variants.append(reporting.entry(plan.work, take, entries))
    except BaseException:
        rollback()
        raise
    for number, own in actions.items():
        keyframes.activate_action(owners[number], next(iter(own.values())))
    return CastResult({number: owners[number] for number in actions}, actions, variants, failures)


def _part(plan: CastPlan, take: CastTake, number: int, owner: bpy.types.Object | None) -> baking.Plan:
    """Return the plan of one member's take."""
    role = plan.work.roles[number]
    job = replace(role.job_on(take.targets.get(number, "")), seed=take.takes[number].seed, variants=1)
    name = role.member.name
    return baking.Plan(Work(job, role.views[0]), plan.geometry, owner, plan.frame_start, name=name)


def sentence(result: CastResult) -> str:
    """Return the sentence that is reported after a cast."""
    names = ", ".join(f"'{owner.name}'" for owner in result.owners.values())
    last = max(variant["frame_end"] for variant in result.variants)
    text = f"Baked takes of {len(result.owners)} characters ({names}), up to frame {last}."
    if result.failures:
        text += f" {len(result.failures)} failed: {result.failures[0].message}"
    warnings = [text for variant in result.variants for text in variant["warnings"]]
    if warnings:
        text += f" {len(warnings)} warnings: {warnings[0]}"
    return text
