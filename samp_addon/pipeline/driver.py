"""From a job and its scene to takes: the one driver behind operators and batch. Without Blender.

Batches of seeds, attempts, actions in a row, the order of refinement, and what a stopped run goes on with: all of
it stands here once. A method makes one attempt and knows nothing of the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from ..body import human, proportions
from ..body.human import Human
from ..methods import registry
from ..methods.method import Method
from ..methods.scene_view import SceneView
from ..methods.step import Step
from ..methods.take import Failure, Take
from ..motion import Motion
from ..progress import Progress, SubProgress
from ..refine import refinement
from ..refine.refinement import Surroundings
from . import other_body, steps
from .job import Job
from .refine_takes import Refine, refine_take

AT_ONCE = 32
"""Takes that are generated, and saved, before the next ones are begun."""

Made = tuple[list[Take], list[Failure]]

Remake = Callable[[Callable[[SceneView], SceneView], Sequence[int]], Made]
"""Generates the takes of some seeds again, each step in a changed view of the scene."""

Settle = Callable[[Made, Remake, Mapping[str, Method], Progress], Made]
"""What is done to generated takes before they are refined, such as a wait for others; may make some again."""


@dataclass(frozen=True)
class Work:
    """A job and all that is known of its scene.

    views: the scene as each step sees it. surroundings: what its takes are refined against; None where they are not.
    body: that shows the takes; None for the default human. pose: one frame in which all takes begin, in the default
    proportions, or None. settle: see Settle; None where takes stay as they are generated.
    """

    job: Job
    views: Sequence[SceneView]
    surroundings: Surroundings | None = None
    body: Human | None = None
    pose: Motion | None = None
    settle: Settle | None = None


@dataclass(frozen=True)
class Toolbox:
    """What the driver works with, which tests and evaluations replace: methods by name, and the optimiser."""

    methods: Mapping[str, Method] = field(default_factory=lambda: registry.METHODS)
    refine: Refine = field(default_factory=lambda: refinement.refine)


class Store(Protocol):
    """Where the takes of a run are kept, so that a run that was killed goes on with them."""

    def load(self, piece: str) -> Made | None:
        """Return what this piece of the work made, or None if it is to be done."""

    def save(self, piece: str, takes: Sequence[Take], failures: Sequence[Failure]) -> None:
        """Keep what this piece of the work has made."""


def run(
    work: Work,
    progress: Progress = lambda stage, share: None,
    tools: Toolbox | None = None,
    store: Store | None = None,
    on_take: Callable[[Take], None] = lambda take: None,
) -> Made:
    """Return the job's takes in the order of their seeds, and what failed.

    store: where finished pieces of the work are kept and looked up. on_take: called with each finished take. May run
    in a thread; raises what the progress callback raises, and SampError where no take can be made at all.
    """
    tools = tools or Toolbox()
    takes: list[Take] = []
    failures: list[Failure] = []
    seeds = work.job.seeds
    batches = [seeds[begin : begin + AT_ONCE] for begin in range(0, len(seeds), AT_ONCE)]
    for count, batch in enumerate(batches):
        part = SubProgress(progress, count / len(batches), 1 / len(batches))
        for made, failed in _batch(work, batch, tools, store, part):
            for take in made:
                takes.append(take)
                on_take(take)
            failures += failed
    return takes, failures


def _batch(
    work: Work, seeds: Sequence[int], tools: Toolbox, store: Store | None, progress: Progress
) -> Iterator[Made]:
    """Yield the finished takes of some seeds as they come, and what failed."""
    chosen = [
        (tools.methods[step.method], step, view)
        for step, view in zip(work.job.steps, work.views, strict=True)
    ]
    takes, failures = _remembered(
        store, f"{seeds[0]}-{len(seeds)}", lambda: _generated(work, chosen, seeds, tools, progress)
    )
    if work.surroundings is None:
        yield takes, failures
        return
    yield [], failures
    for count, take in enumerate(takes):
        part = SubProgress(progress, count / len(takes), 1 / len(takes))
        yield _remembered(
            store, f"{take.seed}-refined", lambda take=take, part=part: _refined(work, take, tools, part)
        )
    progress("Done", 1.0)


def _generated(
    work: Work,
    chosen: Sequence[tuple[Method, Step, SceneView]],
    seeds: Sequence[int],
    tools: Toolbox,
    progress: Progress,
) -> Made:
    made = _fitted(work, chosen, seeds, progress)
    if work.settle is None:
        return made

    def remake(changed: Callable[[SceneView], SceneView], seeds: Sequence[int]) -> Made:
        again = [(method, step, changed(view)) for method, step, view in chosen]
        return _fitted(work, again, seeds, progress)

    return work.settle(made, remake, tools.methods, progress)


def _fitted(
    work: Work, chosen: Sequence[tuple[Method, Step, SceneView]], seeds: Sequence[int], progress: Progress
) -> Made:
    """Return the takes of some seeds for the body that shows them, and what failed."""
    takes, failures = steps.generate(chosen, seeds, progress)
    body = work.body or human.load()
    takes = [other_body.fitted(take, body) for take in takes]
    if work.pose is not None:
        pose = proportions.adapt(work.pose, body.joints)
        takes = [steps.from_pose(take, pose) for take in takes]
    return takes, failures


def _refined(work: Work, take: Take, tools: Toolbox, progress: Progress) -> Made:
    refined, failure = refine_take(take, work.surroundings, work.body or human.load(), tools.refine, progress)
    return [refined], [] if failure is None else [failure]


def _remembered(store: Store | None, piece: str, work: Callable[[], Made]) -> Made:
    """Return what a piece of work makes, or has made in an earlier run. Pieces with failures are not kept."""
    made = store.load(piece) if store else None
    if made is None:
        made = work()
        if store and not made[1]:
            store.save(piece, *made)
    return made
