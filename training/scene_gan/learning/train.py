"""Train Scene GAN on a data set; an interrupted training is resumed.

python -m samp_blender.training.scene_gan.learning.train --data DATA/train --work RUN --row all --encoder ENCODER
    --seconds 28800

Writes to RUN: state.pt (every --checkpoint seconds), log.jsonl, curves.png, a sheet of samples, and the averaged
weights in the format of models/weights.py.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from dataclasses import asdict, replace
from pathlib import Path

import torch

from ....models.scene_gan import networks
from ..data import dataset
from . import curves, options
from .trainer import Trainer

STATE = "state.pt"
SHOWN = 8  # windows on a sheet
SAVING = {"cpu": 3.0, "cuda": 12.0}  # seconds reserved for the last save


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--data", type=Path, required=True, help="folder of one split, see data/make.py")
    made.add_argument("--work", type=Path, required=True)
    made.add_argument("--row", choices=options.ROWS, default="all", help="row of table 1, or another view")
    made.add_argument(
        "--encoder", type=Path, help="folder written by pretrain.py (default: a random encoder)"
    )
    made.add_argument(
        "--begin",
        type=Path,
        nargs="+",
        default=[],
        help="folders of trainings to begin with, e.g. of each part",
    )
    made.add_argument("--seconds", type=float, required=True, help="duration of the program")
    made.add_argument(
        "--steps", type=int, help="end after so many steps of the generators in all, if not before"
    )
    made.add_argument("--part", choices=options.PARTS)
    made.add_argument("--view", choices=networks.VIEWS, help="view of the scene that the networks see")
    for name in ("batch", "critic-steps", "width", "noise", "pose-noise", "encoder-width", "seed"):
        made.add_argument(f"--{name}", type=int)
    made.add_argument("--pairs", type=int, help="use so many pairs of windows and pictures (default: all)")
    made.add_argument("--rate", type=float)
    made.add_argument("--average", type=float)
    made.add_argument("--draws", type=int, help="also train the nearest of so many draws towards the truth")
    made.add_argument("--draws-weight", type=float)
    made.add_argument("--spectral", type=float, help="weight of the spectra of velocities in that error")
    made.add_argument("--kept", nargs="*", help="beginnings of the names of weights that are not trained")
    made.add_argument("--moving", type=float, help="share of each batch in which bodies travel")
    made.add_argument("--critics", nargs="*", choices=options.CRITICS, help="default: those of the row; none")
    made.add_argument("--context-weight", type=float)
    made.add_argument(
        "--centre", action="store_true", help="first centre the pose generator, see centring.py"
    )
    made.add_argument("--along", action="store_true", default=None, help="train the encoder as well")
    made.add_argument("--checkpoint", type=float, default=300.0, help="seconds between checkpoints")
    made.add_argument("--report", type=float, default=30.0, help="seconds between lines of the log")
    made.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    made.add_argument("--threads", type=int, default=1, help="CPU threads")
    made.add_argument("--no-sheet", action="store_true")
    made.add_argument("--no-graph", action="store_true", help="on a GPU: do not capture steps as a graph")
    return made


class Run:
    """A training in its folder."""

    def __init__(self, made: Trainer, work: Path, sheets: bool) -> None:
        self.trainer, self.work, self.sheets = made, work, sheets
        self.began = time.time()
        count = min(SHOWN, len(made.data))
        spread = torch.linspace(0, len(made.data) - 1, count).long().to(made.data.device)
        self.shown = made.data.batch(spread)

    def report(self) -> dict[str, float]:
        """Write a line of the log and return it. Raise FloatingPointError where all gradients were dropped."""
        values = self.trainer.losses()
        curves.note(self.work / "log.jsonl", self.trainer.step_number, time.time() - self.began, values)
        if values.get("dropped", 0.0) == 1.0:
            raise FloatingPointError(f"no gradient is finite at step {self.trainer.step_number}")
        return values

    @torch.no_grad()
    def save(self) -> None:
        """Write state, weights, curves and a sheet of samples."""
        self.trainer.save(self.work / STATE)
        averaged = self.trainer.averaged()
        networks.save(averaged, self.work)
        curves.draw(curves.read(self.work / "log.jsonl"), self.work / "curves.png")
        if self.sheets:
            from . import sheet

            scene = averaged.encoder(self.trainer.data.views(self.trainer.options.settings.view, self.shown))
            draw = torch.Generator().manual_seed(1)
            generated = averaged.draw(scene, self.shown.start, draw)
            path = self.work / f"samples_{self.trainer.step_number:07d}.png"
            sheet.of_samples(self.trainer.data, self.shown, generated, path)


def load_encoder(folder: Path, settings: networks.Settings) -> dict[str, torch.Tensor]:
    """Return the tensors of a pretrained encoder. Raise ValueError where its view or width differs."""
    notes = json.loads((folder / "encoder.json").read_text())
    for name in ("view", "scene", "encoder_width"):
        if notes[name] != getattr(settings, name):
            raise ValueError(
                f"the encoder in {folder} has {name} {notes[name]}, not {getattr(settings, name)}"
            )
    return torch.load(folder / "encoder.pt", map_location="cpu", weights_only=True)["encoder"]


def options_of(chosen: argparse.Namespace) -> options.Options:
    """Return the options of a training from the command line."""
    names = ("part", "view", "batch", "critic_steps", "width", "noise", "pose_noise", "encoder_width", "seed", "rate",
             "average", "along", "context_weight", "draws", "draws_weight", "moving", "spectral")  # fmt: skip
    wanted = options.row(chosen.row, **{name: getattr(chosen, name) for name in names})
    kept = {"trajectory": ("trajectory",), "pose": ("pose",), "rough_pose": ()}.get(wanted.part)
    if kept is not None:
        wanted = replace(wanted, critics=kept)
    if chosen.kept is not None:
        wanted = replace(wanted, kept=tuple(chosen.kept))
    if chosen.critics is not None:
        wanted = replace(wanted, critics=tuple(chosen.critics))
    return wanted


def main(arguments: list[str] | None = None) -> int:
    began = time.time()
    chosen = parser().parse_args(arguments)
    torch.set_num_threads(chosen.threads)
    wanted = options_of(chosen)
    chosen.work.mkdir(parents=True, exist_ok=True)
    (chosen.work / "options.json").write_text(json.dumps(asdict(wanted), indent=1) + "\n")
    data = dataset.load(chosen.data, chosen.device, resident=chosen.device != "cpu")
    if chosen.pairs is not None:
        data.keep(chosen.pairs)
    encoder = None if chosen.encoder is None else load_encoder(chosen.encoder, wanted.settings)
    made = Trainer(data, wanted, encoder)
    made.keep_standing()
    if (chosen.work / STATE).exists():
        made.resume(chosen.work / STATE)
        print(f"resumes at step {made.step_number}", flush=True)
    else:
        for folder in chosen.begin:
            made.begin(folder / STATE, json.loads((folder / "options.json").read_text())["part"])
    if not wanted.along and wanted.sees_scene:
        made.cache_features(chosen.work)
    if chosen.centre and not made.step_number:
        made.centre()
    run = Run(made, chosen.work, not chosen.no_sheet)
    if chosen.device != "cpu" and not chosen.no_graph:
        made.capture()
    print(f"{len(data)} pairs on {chosen.device}, ready after {time.time() - began:.0f} s", flush=True)
    end = began + chosen.seconds - SAVING[torch.device(chosen.device).type]
    last = math.inf if chosen.steps is None else chosen.steps
    reported = saved = time.time()
    while time.time() < end and made.step_number < last:
        made.step()
        if time.time() - reported > chosen.report:
            reported = time.time()
            values = run.report()
            text = " ".join(f"{name} {value:.3f}" for name, value in values.items())
            print(f"{time.time() - began:.0f} s step {made.step_number} {text}", flush=True)
        if time.time() - saved > chosen.checkpoint:
            saved = time.time()
            run.save()
    run.report()
    run.save()
    print(f"step {made.step_number}, saved", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
