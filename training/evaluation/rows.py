"""Networks compared in three stages (tables 1 to 5 of the paper): alone, with path following, and finished."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

from ...samp_addon.evaluation import collision
from ...samp_addon.evaluation.obstacles import shared
from ...samp_addon.methods.samp.load_networks import MotionNetwork
from ...samp_addon.methods.samp.networks import Networks
from ...samp_addon.methods.samp.rollout import generator
from ...samp_addon.methods.scene_view import SceneView
from ...samp_addon.methods.take import Take
from . import stages
from .takes import straight_on

COLUMNS = (
    ("success", "success"),
    ("position_error_cm", "PE, cm"),
    ("rotation_error_deg", "RE, deg"),
    ("penetration_5cm_percent", "deeper than 5 cm, %"),
    ("execution_time_s", "execution time, s"),
)


class Version(NamedTuple):
    """A network of the comparison. planner: whether its takes walk around obstacles or straight to their goal."""

    network: MotionNetwork
    planner: bool = True

    def adapted(self, networks: Networks) -> Networks:
        """Return the networks, without the planner where this version has none."""
        return networks if self.planner else straight_on(networks)


def measure(jobs: stages.Jobs, versions: Mapping[str, Version]) -> dict[str, dict[str, stages.Stage]]:
    """Generate and measure the first attempt of each take with each network, at each stage."""
    found: dict[str, dict[str, stages.Stage]] = {}
    for name, version in versions.items():
        run = partial(stages.run, jobs, network=version.network, measures=measures_of, adapt=version.adapted)
        found[name] = {stage: run(stage) for stage in generator.STAGES}
    return found


def measures_of(take: Take, view: SceneView) -> dict:
    """Return the measures of COLUMNS."""
    depth = collision.measures(take.motion, shared(view.geometry.triangles), take.floor)
    return stages.goal_measures(take, view) | depth


def table(action: str, found: Mapping[str, Mapping[str, stages.Stage]]) -> str:
    """Return a Markdown table with a row for each network and stage; failed takes count as unsuccessful."""
    takes = len(next(iter(next(iter(found.values())).values())).numbers)
    lines = [f"{action}: first attempts, {takes} takes of each network and stage, APD of takes of a job", ""]
    lines.append("| network | stage | " + " | ".join(name for _, name in COLUMNS) + " | APD |")
    lines.append("|---" * (len(COLUMNS) + 3) + "|")
    for name, of_stage in found.items():
        for stage, takes_of in of_stage.items():
            cells = [takes_of.estimate(key) for key, _ in COLUMNS]
            text = ["-" if cell is None else str(cell) for cell in cells]
            apart = takes_of.apart()
            text.append("-" if apart is None else f"{apart:.1f}")
            lines.append(f"| {name} | {stage} | " + " | ".join(text) + " |")
    return "\n".join(lines)
