"""Train the networks of the long-term method, stage by stage, on a CPU or a GPU.

python -m samp_blender.training.long_term.train --data long_term.bin --work RUN --minutes 280
python -m samp_blender.training.long_term.train --data long_term.bin --work RUN --stages paper_route paper_pose

The minutes are divided among the stages; a stage whose weights are in RUN is skipped, and one with a checkpoint is
resumed. With --steps, every stage takes that many steps instead. Stages that need the weights of another one wait for
them (--wait), so that several programs can train at once.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import torch

from ...models import weights
from ...models.long_term.guided_route import GuidedRoute
from ...models.long_term.point_net import PointEncoder, PointNet
from ...models.long_term.pose_prior import PosePrior
from .data import LongTermData
from .stages import paper
from .stages.learner import Learner, trained
from .stages.pose import PoseLearner
from .stages.prior import PriorLearner
from .stages.route import RouteLearner
from .stages.segmentation import PointLearner
from .stages.sub_goal import SubGoalLearner

SHIPPED = ("prior", "points", "sub_goal", "route", "pose")
STAGES = (*SHIPPED, *paper.NAMES)
SHARES = {"prior": 0.1, "points": 0.08, "sub_goal": 0.2, "route": 0.22, "pose": 0.4}
"""Relative times of the stages; the paper's networks count 0.1 each."""

BATCHES = {"cpu": {}, "cuda": {"prior": 2048, "points": 128, "sub_goal": 256, "route": 512, "pose": 256}}
REPORT, CHECKPOINT = 10.0, 60.0  # seconds
WAITED = 600.0  # seconds for another program's weights


class Trainings:
    """Learners by stage, each with the networks of earlier stages from the folder."""

    def __init__(self, data: LongTermData, work: Path, batch: int = 0, wait: float = 0.0) -> None:
        self.data, self.work, self.batch, self.wait = data, work, batch, wait

    def learner(self, stage: str) -> Learner:
        """Return the learner of a stage. Raise WeightsError where the weights of an earlier stage are missing."""
        data, device = self.data, self.data.device
        batch = {"batch": self.batch or BATCHES[device.type].get(stage, 0)}
        batch = batch if batch["batch"] else {}
        if stage == "prior":
            return PriorLearner(data, **batch)
        if stage == "points":
            return PointLearner(data, **batch)
        scene = self._scene()
        if stage == "route":
            return RouteLearner(data, scene, **batch)
        if stage == "pose":
            return PoseLearner(data, self._trained("long_term_route", GuidedRoute()), scene, **batch)
        prior = self._trained("long_term_prior", PosePrior())
        if stage == "sub_goal":
            return SubGoalLearner(data, prior, scene, **batch)
        if data.pose is None:
            data.encode(prior)
        kind, sees = paper.parse(stage)
        name = "paper_route" if sees else "paper_route_blind"
        route = self._trained(f"long_term_{name}", paper.network(name)) if kind.route else None
        if device.type == "cuda" and not batch:
            batch = {"batch": 256}
        return paper.PaperLearner(stage, data, prior, scene, route, **batch)

    def _trained(self, name: str, net: torch.nn.Module) -> torch.nn.Module:
        end = time.time() + self.wait
        while not weights.weights_path(name, self.work).with_suffix(".sha256").exists() and time.time() < end:
            time.sleep(0.5)
        return trained(name, net, self.work, self.data.device)

    def _scene(self) -> PointEncoder:
        return self._trained("long_term_points", PointNet()).encoder


def run(learner: Learner, work: Path, seconds: float, steps: int, log: Callable[[str], None]) -> None:
    """Train one stage for ``seconds``, or for ``steps`` if that is not 0, and write its weights."""
    path = work / f"{learner.name}.checkpoint"
    spent = 0.0
    if path.exists():
        state = torch.load(path, map_location=learner.data.device, weights_only=False)
        learner.resume(state)
        spent = state["seconds"]
        log(f"{learner.name} resumes at step {learner.step_number}, {spent:.0f} s")
    began = reported = saved = time.time()
    while True:
        now = time.time()
        done = learner.step_number / steps if steps else (spent + now - began) / max(seconds, 1e-6)
        if done >= 1:
            break
        learner.step(done)
        if now - reported > REPORT:
            reported = now
            log(f"{learner.report()} done {done:.3f}")
        if now - saved > CHECKPOINT:
            saved = now
            _keep(learner, path, spent + now - began)
    log(f"{learner.report()} end")
    learner.save(work)
    path.unlink(missing_ok=True)


def _keep(learner: Learner, path: Path, seconds: float) -> None:
    """Write a checkpoint atomically."""
    part = path.with_suffix(".part")
    torch.save(learner.checkpoint() | {"seconds": seconds}, part)
    part.replace(path)


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True, help="file written by pack.py")
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--stages", nargs="+", choices=STAGES, default=SHIPPED)
    parser.add_argument("--minutes", type=float, default=280.0, help="time of all stages together")
    parser.add_argument("--seconds", type=float, nargs="+", help="time of each stage, instead of --minutes")
    parser.add_argument(
        "--until", type=float, default=0.0, help="time (s since 1970) at which the last stage ends"
    )
    parser.add_argument("--steps", type=int, default=0, help="steps of each stage, instead of a time")
    parser.add_argument("--batch", type=int, default=0)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--begin", type=Path, help="folder with weights of another training, to go on from them"
    )
    parser.add_argument("--rate", type=float, help="learning rate at the start (default: 0.001)")
    parser.add_argument(
        "--wait", type=float, default=0.0, help="seconds to wait for weights of other programs"
    )
    parser.add_argument("--cpu", action="store_true")
    options = parser.parse_args(arguments)
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    device = "cpu" if options.cpu or not torch.cuda.is_available() else "cuda"
    options.work.mkdir(parents=True, exist_ok=True)
    began = time.time()

    def log(line: str) -> None:
        print(f"{time.time() - began:7.1f} {line}", flush=True)

    data = LongTermData.load(options.data, device)
    log(f"{len(data)} frames, {len(data.windows)} windows on {device}")
    made = Trainings(data, options.work, options.batch, options.wait)
    shares = [SHARES.get(stage, 0.1) for stage in options.stages]
    times = options.seconds or [60 * options.minutes * share / sum(shares) for share in shares]
    for stage, planned in zip(options.stages, times, strict=True):
        if weights.weights_path(f"long_term_{stage}", options.work).with_suffix(".sha256").exists():
            log(f"{stage} is already trained")
            continue
        learner = made.learner(stage)
        if options.begin:
            learner.begin_with(options.begin)
        learner.rate = options.rate or learner.rate
        seconds = options.until - time.time() if options.until and stage == options.stages[-1] else planned
        run(learner, options.work, seconds, options.steps, log)


if __name__ == "__main__":
    main()
