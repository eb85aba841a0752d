"""Compute tables 1, 2 and 4 of the long-term paper, and the classifier, on test rooms.

python -m samp_blender.training.long_term.pack --corpus cache/rooms --split test --output long_term_test.bin
python -m samp_blender.training.long_term.evaluation.tables --test long_term_test.bin --train long_term.bin \\
    --weights RUN --corpus cache/rooms --windows 3000 --in-scene 300 --optimised 60 --output long_term.md

Of the pack's windows, those of 61 frames are used. HSNMS needs --train; table 2 and the optimisation need --corpus.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch

from ....models.long_term.layout import FRAMES
from ....models.long_term.pose_prior import PosePrior
from ....samp_addon.motion import Motion
from ...rooms.corpus.store import Corpus
from ..data import LongTermData, Windows
from ..stages.learner import trained
from ..stages.windows import POINTS, RADIUS
from . import classifier, in_scene, intervals
from .predicted import MEASURES, errors, figures
from .trained import Row, rows

BATCH = 64
SCENE = ("non_collision", "contact", "stance_slide")
OPTIMISED = ("ours", "Route+CVAE", "HSNMS")


class Tables:
    """All measures of all rows: values by row, measure and window, and the rooms of the windows."""

    def __init__(self, data: LongTermData, prior: PosePrior, chosen: torch.Tensor, seed: int = 0) -> None:
        self.data, self.prior, self.chosen, self.seed = data, prior, chosen, seed
        self.values: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
        self.rooms: dict[str, list[int]] = defaultdict(list)
        self.joints: dict[str, list[torch.Tensor]] = defaultdict(list)
        self.accuracies: dict[str, float] = {}

    def batches(self, count: int | None = None) -> Iterator[tuple[Windows, torch.Tensor]]:
        """Yield windows and their clouds, the same for every row."""
        generator = torch.Generator(device=self.data.device).manual_seed(self.seed)
        for part in self.chosen[:count].split(BATCH):
            windows = self.data.window_batch(part)
            yield windows, self.data.cloud(windows, POINTS, RADIUS, generator)

    @torch.no_grad()
    def accuracy(self, row: Row) -> None:
        """Compute tables 1 and 4 for a row."""
        name = label(row)
        for windows, cloud in self.batches():
            made = row.predict(windows, cloud)
            self._add(name, windows, errors(self.data, self.prior, windows, made))
            self.joints[name].append(figures(self.data, made, windows.betas)[0])

    def classify(self, row: Row) -> None:
        """Compute the accuracy of the classifier for a row, after that of `captured`."""
        name = label(row)
        true, made = torch.cat(self.joints["captured"]), torch.cat(self.joints[name])
        self.accuracies[name] = classifier.accuracy(true, made, np.array(self.rooms[name]))

    def in_scene(self, row: Row, scene: in_scene.Rooms, count: int, optimised: int) -> None:
        """Compute table 2 for a row, and all tables after the optimisation of the first ``optimised`` windows."""
        name, done = label(row), 0
        for windows, cloud in self.batches(count):
            with torch.no_grad():
                made = row.predict(windows, cloud)
            numbers = in_scene.room_numbers(self.data, windows)
            order = np.argsort(numbers, kind="stable")
            moved = in_scene.motions(self.data, windows, made)
            for k in order:
                found = scene.measures(moved[k], int(numbers[k]), in_scene.body(windows, int(k)))
                self._one(name, int(numbers[k]), found)
            for k in order:
                if done >= optimised:
                    break
                done += 1
                self._optimise(f"{name}, optimised", windows, int(k), moved[k], int(numbers[k]), scene)

    def _optimise(
        self, name: str, windows: Windows, k: int, motion: Motion, number: int, scene: in_scene.Rooms
    ) -> None:
        human = in_scene.body(windows, k)
        better = scene.optimised(motion, number, human)
        one = self.data.window_batch(windows.index[k : k + 1])
        made = in_scene.from_motions(self.data, one, [better])
        self._add(name, one, errors(self.data, self.prior, one, made))
        self._one(name, number, scene.measures(better, number, human))

    def _add(self, name: str, windows: Windows, found: dict[str, torch.Tensor]) -> None:
        for measure, values in found.items():
            self.values[name][measure] += values.tolist()
        self.rooms[name] += in_scene.room_numbers(self.data, windows).tolist()

    def _one(self, name: str, number: int, found: dict[str, float]) -> None:
        for measure, value in found.items():
            self.values[name][measure].append(value)
        self.rooms[f"{name}/scene"].append(number)

    def lines(self) -> list[str]:
        """Return the lines of the tables in Markdown: means with 95 % intervals over rooms."""
        head = [*MEASURES, *SCENE, "classifier"]
        made = ["| method | " + " | ".join(head) + " |", "|---" * (len(head) + 1) + "|"]
        for name, measures in self.values.items():
            cells = []
            for measure in head[:-1]:
                rooms = self.rooms[f"{name}/scene" if measure in SCENE else name]
                if not measures.get(measure):
                    cells.append("")
                    continue
                cells.append(
                    "{:.2f} [{:.2f}, {:.2f}]".format(*intervals.mean(np.array(measures[measure]), rooms))
                )
            cells.append(f"{self.accuracies[name]:.2f}" if name in self.accuracies else "")
            made.append(f"| {name} | " + " | ".join(cells) + " |")
        return made


def label(row: Row) -> str:
    """Return the name of a row, marked where the method does not see the scene."""
    sees = {True: "", False: ", no scene", None: ""}[row.scene]
    return row.name + ("" if row.name in ("HSNMS", "interpolation") else sees)


def choose(data: LongTermData, count: int, seed: int) -> torch.Tensor:
    """Return the rows (N,) of random windows of the paper's length."""
    every = data.rows[FRAMES]
    order = torch.randperm(len(every), generator=torch.Generator().manual_seed(seed))
    return every[order[:count].to(every.device)]


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--test", type=Path, required=True, help="pack of test rooms")
    parser.add_argument("--train", type=Path, help="pack of training rooms, for HSNMS")
    parser.add_argument("--weights", type=Path, required=True)
    parser.add_argument("--corpus", type=Path, help="corpus of the test rooms, for table 2")
    parser.add_argument("--windows", type=int, default=3000)
    parser.add_argument("--in-scene", type=int, default=300)
    parser.add_argument("--optimised", type=int, default=60)
    parser.add_argument("--no-classifier", action="store_true")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, help="Markdown file; values are written next to it as .json")
    options = parser.parse_args(arguments)
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    data = LongTermData.load(options.test, device)
    bank = LongTermData.load(options.train, device) if options.train else None
    prior = trained("long_term_prior", PosePrior(), options.weights, device)
    tables = Tables(data, prior, choose(data, options.windows, options.seed), options.seed)
    found = rows(options.weights, bank, device)
    scene = in_scene.Rooms(Corpus(options.corpus)) if options.corpus else None
    for row in reversed(found):  # captured motion first
        began = time.time()
        tables.accuracy(row)
        if not options.no_classifier and row.name != "captured":
            tables.classify(row)
        if scene is not None:
            some = options.optimised if row.name in OPTIMISED else 0
            tables.in_scene(row, scene, options.in_scene, some)
        print(f"{label(row)}: {time.time() - began:.0f} s", flush=True)
    text = "\n".join(tables.lines())
    print(text)
    if options.output:
        options.output.write_text(text + "\n")
        options.output.with_suffix(".json").write_text(json.dumps(tables.values))


if __name__ == "__main__":
    main()
