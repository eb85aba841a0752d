"""PE and RE of three stages of the same takes: the network alone, with path following, and finished.

Finishing blends the last frames onto the goal, so the finished numbers alone say little of a network. All takes count,
also those that got stuck; each is compared with its goal on the object.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

from ...samp_addon.errors import SampError
from ...samp_addon.evaluation import metrics
from ...samp_addon.methods.method import Draw
from ...samp_addon.methods.samp import goals
from ...samp_addon.methods.samp.load_networks import MotionNetwork
from ...samp_addon.methods.samp.method import Samp
from ...samp_addon.methods.samp.networks import Networks
from ...samp_addon.methods.samp.rollout import generator
from ...samp_addon.methods.scene_view import SceneView
from ...samp_addon.methods.take import Take
from ...samp_addon.pipeline.job import Job
from .tables import Estimate


@dataclass
class StageErrors:
    """PE (cm), RE (degrees) and piece or room of each take of a stage, and how many takes there are none of."""

    position: list[float] = field(default_factory=list)
    rotation: list[float] = field(default_factory=list)
    clusters: list[str] = field(default_factory=list)
    failed: int = 0

    def add(self, takes: Sequence[Take], cluster: str) -> None:
        """Measure takes with a goal."""
        for take in takes:
            self.position.append(metrics.position_error(take.motion, take.goal))
            self.rotation.append(metrics.rotation_error(take.motion, take.goal))
            self.clusters.append(cluster)


def networks_of_stage(stage: str, network: MotionNetwork | None = None) -> Networks:
    """Return networks whose takes end at a stage, one of generator.STAGES. network: the shipped one if left out."""
    return Networks(goals.sample_goals, partial(generator.generate, network=network, stage=stage))


def measure(
    jobs: Sequence[tuple[Job, SceneView, str]], network: MotionNetwork | None = None
) -> dict[str, StageErrors]:
    """Generate the first attempt of each take at each stage. jobs: with the piece or room that they are in."""
    found = {}
    for stage in generator.STAGES:
        method = Samp(networks_of_stage(stage, network))
        errors = found[stage] = StageErrors()
        for job, view, cluster in jobs:
            draws = [Draw(seed, seed) for seed in job.seeds]
            try:
                takes, failures = method.generate(job.steps[0], view, draws, lambda stage, share: None)
            except SampError:
                takes, failures = [], draws
            errors.add(takes, cluster)
            errors.failed += len(failures)
    return found


def table(action: str, found: dict[str, StageErrors]) -> str:
    """Markdown: a row for each stage, intervals by bootstrap over pieces or rooms."""
    lines = [
        f"{action}: first attempts, all takes",
        "",
        "| stage | takes | without a take | PE, cm | RE, deg |",
        "|---|---|---|---|---|",
    ]
    for stage, errors in found.items():
        cells = ["-", "-"]
        if errors.position:
            cells = [
                str(Estimate.of(values, errors.clusters)) for values in (errors.position, errors.rotation)
            ]
        lines.append(f"| {stage} | {len(errors.position)} | {errors.failed} | {cells[0]} | {cells[1]} |")
    return "\n".join(lines)
