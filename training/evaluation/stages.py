"""Measures of three stages of the same takes: the network alone, with path following, and finished.

Finishing blends the last frames onto the goal, so finished measures alone say little about a network. All takes count,
including stuck ones; each is compared with its goal on the object. Two variants of the guided takes show what the
network uses: one without the object, and one in which only z differs between the takes of a job.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...samp_addon.errors import SampError
from ...samp_addon.evaluation import diversity, metrics, posture, rest_posture
from ...samp_addon.evaluation.obstacles import shared
from ...samp_addon.methods.method import Draw
from ...samp_addon.methods.samp import goals
from ...samp_addon.methods.samp.load_networks import MotionNetwork
from ...samp_addon.methods.samp.method import Samp
from ...samp_addon.methods.samp.networks import Networks
from ...samp_addon.methods.samp.request import Request
from ...samp_addon.methods.samp.rollout import generator
from ...samp_addon.methods.scene_view import SceneView
from ...samp_addon.methods.take import Take
from ...samp_addon.motion import Motion
from ...samp_addon.pipeline.job import Job
from ...samp_addon.scene.geometry import sample_surface
from ...samp_addon.skeleton import BODY_COUNT
from .tables import Estimate

Jobs = Sequence[tuple[Job, SceneView, str]]
Change = Callable[[Sequence[Request]], list[Request]]

NETWORK, GUIDED, FINISHED = generator.STAGES
HIDDEN, Z_ALONE = "guided, object hidden", "guided, z alone"
ROWS = (
    ("success", "success, share"),
    ("position_error_cm", "PE, cm"),
    ("rotation_error_deg", "RE, deg"),
    ("penetration_5cm_percent", "frames deeper than 5 cm, %"),
    ("touches_back", "back against the rest, share of backed seats"),
    ("hanging_feet_cm", "feet over the floor in the hold, low seats, cm"),
    ("air_squat_s", "squat in the air, s"),
    ("unsupported_s", "without support, s"),
    ("seated_speed_m_s", "pelvis while seated, m/s"),
    ("stance_slide_cm_s", "stance slide, cm/s"),
    ("glide_s", "gliding on both feet, s"),
    ("jerk_m_s3", "jerk, m/s^3"),
    ("walk_knee_deg", "walking: knee flexion, deg"),
    ("walk_straight_deg", "walking: straightest knee, deg"),
    ("walk_elbow_deg", "walking: elbow flexion, deg"),
    ("walk_neck_deg", "walking: neck, deg"),
    ("walk_step_width_m", "walking: step width, m"),
    ("idle_knee_deg", "idle: knee flexion, deg"),
)
BACK_POINTS = 40_000  # on the target: they must lie closer together than the gap that counts as touching
LAST_SECONDS = 2.0  # seconds at the end of a take for which the change by finishing is reported separately


@dataclass
class Stage:
    """The takes of a stage by (job, seed), their measures, piece or room, and the number of failed takes."""

    motions: dict[tuple[int, int], Motion] = field(default_factory=dict)
    numbers: list[dict] = field(default_factory=list)
    clusters: list[str] = field(default_factory=list)
    failed: int = 0

    def estimate(self, key: str) -> Estimate | None:
        """Return the mean of a measure over all takes that have it; failed takes count as unsuccessful."""
        known = [k for k, numbers in enumerate(self.numbers) if numbers.get(key) is not None]
        if not known:
            return None
        return Estimate.of([float(self.numbers[k][key]) for k in known], [self.clusters[k] for k in known])

    def apart(self) -> float | None:
        """Return the mean APD, frame by frame, between the takes of each job."""
        jobs: dict[int, list[Motion]] = {}
        for (job, _), motion in self.motions.items():
            jobs.setdefault(job, []).append(motion)
        found = [diversity.diversity_in_time(motions) for motions in jobs.values() if len(motions) > 1]
        return float(np.mean(found)) if found else None


def networks_of_stage(
    stage: str,
    network: MotionNetwork | None = None,
    change: Change | None = None,
    without: Collection[str] = (),
) -> Networks:
    """Return networks whose takes end at a stage, one of generator.STAGES.

    network: by default the shipped one. change: applied to the requests before the rollout. without: names in
    finish.CORRECTIONS to leave out.
    """

    def generate(
        requests: Sequence[Request], progress: Callable[[float], None] = lambda share: None
    ) -> list[Motion | SampError]:
        return generator.generate(change(requests) if change else requests, progress, network, stage, without)

    return Networks(goals.sample_goals, generate)


def without_object(requests: Sequence[Request]) -> list[Request]:
    """Return the requests with empty voxels."""
    return [replace(request, object_triangles=None) for request in requests]


def with_own_z(requests: Sequence[Request]) -> list[Request]:
    """Return copies of the first request, with the z of each request."""
    return [replace(requests[0], latent_seed=request.seed) for request in requests]


def measure(jobs: Jobs, network: MotionNetwork | None = None) -> dict[str, Stage]:
    """Generate and measure the first attempt of each take at each stage. jobs: with the name of the piece or room."""
    found = {stage: run(jobs, stage, network) for stage in generator.STAGES}
    found[HIDDEN] = run(jobs, GUIDED, network, change=without_object)
    found[Z_ALONE] = run(jobs, GUIDED, network, goal_measures, with_own_z)
    return found


def run(
    jobs: Jobs,
    stage: str,
    network: MotionNetwork | None = None,
    measures: Callable[[Take, SceneView], dict] | None = None,
    change: Change | None = None,
    without: Collection[str] = (),
    adapt: Callable[[Networks], Networks] = lambda networks: networks,
) -> Stage:
    """Generate and measure the first attempt of each take at a stage; see networks_of_stage.

    measures: function of a take, by default all_measures. adapt: function of the networks, as straight_on.
    """
    measures = measures or all_measures
    method = Samp(adapt(networks_of_stage(stage, network, change, without)))
    out = Stage()
    for number, (job, view, cluster) in enumerate(jobs):
        draws = [Draw(seed, seed) for seed in job.seeds]
        try:
            takes, failures = method.generate(job.steps[0], view, draws, lambda stage, share: None)
        except SampError:
            takes, failures = [], draws
        out.failed += len(failures)
        out.motions |= {(number, take.seed): take.motion for take in takes}
        out.numbers += [measures(take, view) for take in takes] + [{"success": False}] * len(failures)
        out.clusters += [cluster] * (len(takes) + len(failures))
    return out


def goal_measures(take: Take, view: SceneView) -> dict:
    """Return the measures of a take that depend only on its goal."""
    return metrics.goal_measures(take.motion, take.goal)


def all_measures(take: Take, view: SceneView) -> dict:
    """Return all measures of a take in its scene."""
    motion = take.motion
    obstacles = shared(view.geometry.triangles)
    numbers = metrics.measure(motion, take.goal, obstacles, take.floor) | posture.measures(motion)
    if take.goal.action == "sit" and view.target is not None:
        points = sample_surface(view.target, BACK_POINTS, seed=0)[0]
        gap = rest_posture.back_gap(motion, max(len(motion) - int(motion.fps / 2), 0), points)
        numbers["touches_back"] = None if gap is None else gap <= rest_posture.TOUCHING_BACK
    return numbers


def changes_by_finishing(found: dict[str, Stage]) -> tuple[float, float] | None:
    """Return the mean displacement of the joints by finishing, cm: in the last two seconds, and in all frames.

    Takes that finishing makes longer (finishing/unhurried.py) are left out.
    """
    last, whole = [], []
    for key, motion in found[FINISHED].motions.items():
        before = found[GUIDED].motions.get(key)
        if before is None or len(before) != len(motion):
            continue
        joints = (m.forward_kinematics()[0][:, :BODY_COUNT] for m in (before, motion))
        moved = np.linalg.norm(np.subtract(*joints), axis=-1).mean(1)
        last.append(moved[-int(LAST_SECONDS * motion.fps) :].mean())
        whole.append(moved.mean())
    return (100 * float(np.mean(last)), 100 * float(np.mean(whole))) if last else None


def table(action: str, found: dict[str, Stage]) -> str:
    """Return a Markdown table with a column for each stage; intervals are bootstrapped over pieces or rooms."""
    takes = len(found[FINISHED].numbers)
    lines = [
        f"{action}: first attempts, all {takes} takes",
        "",
        "| measure | network alone | with path following | finished |",
        "|---|---|---|---|",
    ]
    missing = [str(found[stage].failed) for stage in generator.STAGES]
    lines.append("| takes that got stuck | " + " | ".join(missing) + " |")
    for key, name in ROWS:
        cells = [found[stage].estimate(key) for stage in generator.STAGES]
        if any(cells):
            lines.append(f"| {name} | " + " | ".join("-" if c is None else str(c) for c in cells) + " |")
    lines += ["", *_remarks(found)]
    return "\n".join(lines)


def _remarks(found: dict[str, Stage]) -> list[str]:
    """Return sentences on the use of object and z by the network, and on the change by finishing."""
    lines = []
    if (moved := changes_by_finishing(found)) is not None:
        lines.append(
            f"Finishing moves the joints by {moved[0]:.1f} cm in the last two seconds and {moved[1]:.1f} cm in all."
        )
    usual, hidden = (found[stage].estimate("position_error_cm") for stage in (GUIDED, HIDDEN))
    if usual and hidden and found[HIDDEN].clusters:
        ratio = hidden.mean / max(usual.mean, 1e-9)
        lines.append(
            f"With the object hidden, PE of guided takes is {hidden.mean:.1f} cm ({ratio:.2f} times)."
        )
    every, alone = found[GUIDED].apart(), found[Z_ALONE].apart()
    if every and alone is not None:
        lines.append(
            f"APD of guided takes is {every:.1f}; by z alone {alone:.1f} ({alone / every:.2f} times)."
        )
    return lines
