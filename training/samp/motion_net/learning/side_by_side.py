"""Run several trainings of MotionNet on one GPU side by side until a fixed time.

python -m samp_blender.training.samp.motion_net.learning.side_by_side --data motion.bin --output OUT --seconds 540
    --run wide:hidden=512,batch=2048 --run slim:hidden=256,batch=2048,seed=1

Each training replays its graph on a separate stream; a single one is limited by the latency of its small kernels.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import torch

from ..schedule import Schedule
from . import frames, pieces
from .trainer import Trainer, window

STEPS = 20  # steps of one training that are queued together
DEFAULTS = {
    "rate": 4e-4, "sampling_from": 0.1, "sampling_to": 0.35, "least_truth": 0.3, "kl_weight": 0.6, "prior_share": 0.5,
    "held": 16, "most_frames": 120, "average": 0.995,
}  # fmt: skip
SAVING = 12.0  # seconds reserved for the last checkpoint


class Run:
    """One of the trainings: its Trainer, its stream, and the events that mark its progress on the GPU."""

    def __init__(self, name: str, options: dict, data: frames.Frames, graph: bool, fuse: bool) -> None:
        self.name, self.options = name, options
        # The types are texts, since the schedule's annotations are not evaluated. Switches are written as 1 and 0.
        kinds = {field.name: field.type for field in dataclasses.fields(Schedule)}
        known = {k: v for k, v in options.items() if k in kinds}
        schedule = Schedule(**{k: bool(v) if kinds[k] == "bool" else v for k, v in known.items()})
        self.trainer = Trainer(data, schedule, options["batch"], options["seed"])
        self.on_gpu = data.device.type == "cuda"
        self.stream = torch.cuda.Stream() if self.on_gpu else None
        self.queued: list = []
        self.last_finite: dict[str, torch.Tensor] = {}
        if fuse:
            self.trainer.compile()
        if self.on_gpu and graph:
            self.trainer.capture()

    def queue_steps(self, done: float) -> bool:
        """Queue STEPS steps unless two groups are still running; return whether they were queued."""
        if not self.on_gpu:
            self.trainer.step(done)
            return True
        self.queued = [event for event in self.queued if not event.query()]
        if len(self.queued) >= 2:
            return False
        with torch.cuda.stream(self.stream):
            for _ in range(STEPS):
                self.trainer.step(done)
            event = torch.cuda.Event()
            event.record()
        self.queued.append(event)
        return True

    def report(self) -> str:
        """Return the mean losses since the last report; restore the last finite weights if they are not finite."""
        with torch.cuda.stream(self.stream):
            losses = self.trainer.losses()
            finite = all(math.isfinite(value) and abs(value) < 1e6 for value in losses.values())
            finite = finite and all(bool(v.isfinite().all()) for v in self.trainer.average.values())
            if finite:
                self.last_finite = {k: v.clone() for k, v in self.trainer.average.items()}
            elif self.last_finite:
                self.trainer.recover(self.last_finite)
        text = " ".join(f"{name} {value:.3f}" for name, value in losses.items())
        return (
            f"{self.name} step {self.trainer.step_number} {text}{'' if finite else ' NOT FINITE: restored'}"
        )


def parse_run(text: str) -> tuple[str, dict]:
    """Return name and options of NAME:KEY=VALUE,KEY=VALUE..."""
    name, _, rest = text.partition(":")
    options: dict = DEFAULTS | {"batch": 2048, "seed": 0, "hidden": 512, "encoder": 0}
    for pair in filter(None, rest.split(",")):
        key, _, value = pair.partition("=")
        options[key] = _number(value)
    return name, options


def _number(text: str) -> int | float | str:
    """Return an int or a float where the text is one, otherwise the text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


class Log:
    """Writes lines to the screen and to a file, with the seconds since the start of the program."""

    def __init__(self, path: Path, began: float) -> None:
        self.path, self.began = path, began

    def __call__(self, line: str) -> None:
        line = f"{time.time() - self.began:6.1f} {line}"
        print(line, flush=True)
        with self.path.open("a") as file:
            file.write(line + "\n")


def save(runs: list[Run], starts: dict[str, torch.Tensor], output: Path, scratch: Path) -> None:
    """Write the averaged weights of all runs, in pieces."""
    for run in runs:
        with torch.cuda.stream(run.stream):
            pieces.write(output, run.name, run.trainer.exported() | starts, scratch)
            if run.options["encoder"]:
                pieces.write(output, f"{run.name}_encoder", run.trainer.encoder(), scratch)
    options = {run.name: run.options | {"steps": run.trainer.step_number} for run in runs}
    pieces.write_contents(output, {"runs": options}, scratch)


def train(runs: list[Run], log: Log, end: float, checkpoint: float, write: Callable[[], None]) -> None:
    """Train all runs until ``end`` (time.time()), with a report every 5 s and a checkpoint every ``checkpoint`` s."""
    began = reported = saved = time.time()
    while (now := time.time()) < end:
        done = min((now - began) / (end - began), 1.0)
        queued = [run.queue_steps(done) for run in runs]
        if not any(queued):
            time.sleep(0.0005)
        if now - reported > 5:
            reported = now
            for run in runs:
                log(f"{run.report()} done {done:.3f} steps/s {run.trainer.step_number / (now - began):.0f}")
        if now - saved > checkpoint:
            saved = now
            write()
    for run in runs:
        log(f"{run.report()} end")
    write()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seconds", type=float, required=True, help="duration of the program")
    parser.add_argument("--run", action="append", required=True, metavar="NAME:KEY=VALUE,...")
    parser.add_argument("--checkpoint", type=float, default=60.0, help="seconds between checkpoints")
    parser.add_argument("--no-graph", action="store_true", help="do not capture steps as a graph")
    parser.add_argument("--fuse", action="store_true", help="compile small operations into fewer kernels")
    parser.add_argument("--cpu", action="store_true")
    options = parser.parse_args()
    began = time.time()
    options.output.mkdir(parents=True, exist_ok=True)
    log = Log(options.output / "log.txt", began)
    device = "cpu" if options.cpu or not torch.cuda.is_available() else "cuda"
    torch.backends.cuda.matmul.allow_tf32 = False
    data, starts = frames.load_with_starts(options.data, device, window())
    log(f"{len(data)} frames, {int(data.usable.sum())} usable, {len(data.starts)} starts on {device}")
    runs = []
    for text in options.run:
        runs.append(Run(*parse_run(text), data, not options.no_graph, options.fuse))
        log(f"{text} ready")
    # On the file system of the output, so that moving a file is atomic.
    with tempfile.TemporaryDirectory(dir=options.output) as scratch:
        write = lambda: save(runs, starts, options.output, Path(scratch))
        end = began + options.seconds - (SAVING if device == "cuda" else 3.0)
        train(runs, log, end, options.checkpoint, write)
    log("saved")


if __name__ == "__main__":
    main()
