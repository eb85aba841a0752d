"""Train MotionNet (section 3.4): rollouts with scheduled sampling, one optimiser step per frame. Resumes, logs.

python -m samp_blender.training.samp.motion_net.train --data cache/motion.npz --work RUN_FOLDER --steps 20000
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import torch

from ....models.baselines import NETWORKS
from ....models.motion_net import HIDDEN
from .learning import frames
from .learning.trainer import WINDOW, Trainer, window
from .schedule import Schedule

CHECKPOINT = 300  # seconds between two checkpoints
REPORT = WINDOW  # steps between two lines of the log


def arguments() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--data", type=Path, required=True)
    add("--work", type=Path, required=True, help="folder for checkpoints and the log")
    add("--steps", type=int, default=20000)
    add("--minutes", type=float, help="train for this time instead of a number of steps")
    add("--batch", type=int, default=512)
    add("--rate", type=float, default=4e-4)
    add(
        "--sampling", type=float, nargs=2, default=(0.1, 0.35), help="share of the training: P falls from, to"
    )
    add("--least-truth", type=float, default=0.3, help="P never falls below this")
    add("--kl", type=float, default=0.6, help="weight of the KL term")
    add("--prior", type=float, default=0.5, help="share of rollouts with z as at run time")
    add("--held", type=int, default=0, help="components of z that are the style of a take, 0 to 16")
    add("--longest", type=int, default=WINDOW, help="frames of the longest rollouts")
    add(
        "--no-drift",
        action="store_true",
        help="observe goals from the captured root, as in the paper",
    )
    add("--network", choices=NETWORKS, default="motion_net")
    add("--hidden", type=int, default=HIDDEN, help="width of the prediction network")
    add("--no-object", action="store_true", help="ablation: hide the object from the network")
    add("--no-goal-frame", action="store_true", help="ablation: no trajectory relative to the goal")
    add(
        "--no-augmentation",
        action="store_true",
        help="ablation: no mirror images, one piece for each capture",
    )
    add("--bfloat16", action="store_true", help="on a CPU with instructions for bfloat16: twice as fast")
    add("--begin", type=Path, help="checkpoint, or folder of exported weights, to begin with")
    add("--seed", type=int, default=0)
    return parser


def schedule_of(options: argparse.Namespace) -> Schedule:
    """Return the schedule for parsed options."""
    return Schedule(
        options.rate, *options.sampling, options.least_truth, options.kl, options.prior, options.network,
        not options.no_object, options.hidden, options.held, options.longest,
        drifts=not options.no_drift, sees_goal_frame=not options.no_goal_frame,
        augmented=not options.no_augmentation, bfloat16=options.bfloat16,
    )  # fmt: skip


def main() -> None:
    options = arguments().parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    data = frames.load(options.data, device, window())
    trainer = Trainer(data, schedule_of(options), options.batch, options.seed)
    checkpoint = options.work / "checkpoint.pt"
    if checkpoint.exists():
        trainer.resume(checkpoint)
    elif options.begin is not None:
        trainer.begin_with(options.begin)
    if device == "cuda":
        trainer.capture()
    began = saved = time.time()
    first, limit = trainer.step_number, (options.minutes or 0) * 60

    def share_done() -> float:
        return (time.time() - began) / limit if limit else trainer.step_number / options.steps

    while (done := share_done()) < 1:
        trainer.step(done)
        if trainer.step_number % REPORT:
            continue
        rate = (trainer.step_number - first) * options.batch / (time.time() - began)
        text = " ".join(f"{name} {value:.3f}" for name, value in trainer.losses().items())
        line = f"step {trainer.step_number} done {done:.3f} {text} frames/s {rate:.0f}"
        with (options.work / "log.txt").open("a") as log:
            log.write(line + "\n")
        print(line, flush=True)
        if time.time() - saved > CHECKPOINT:
            trainer.save(checkpoint)
            saved = time.time()
    trainer.save(checkpoint)


if __name__ == "__main__":
    main()
