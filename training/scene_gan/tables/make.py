"""Compute tables 1, 2 and 4 of the paper on the test rooms.

python -m samp_blender.training.scene_gan.tables.make --data DATA/test --erd ERD --run csgn=RUNS/csgn --run all=RUNS/all
    --frames 10000 --output tables.json

For each run: Motion FID, non-collision with intervals over rooms, behaviour, and the spread over time. "captured" is
one half of the captured windows against the other; its collisions are those of the data.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from ....models.scene_gan import networks
from ....models.scene_gan.networks import SceneGan
from ....models.scene_gan.projection import Motions
from ..data import dataset
from ..data.dataset import Batch, Dataset
from . import erd, measures

BATCH = 50
RESAMPLED = 1000
SPREAD_OF = (40, 5)  # starts, samples of each
Draw = Callable[[Batch], Motions]


def drawing(made: SceneGan, data: Dataset, seed: int) -> Draw:
    """Return a function from a batch to generated windows."""
    random = torch.Generator().manual_seed(seed)

    def draw(batch: Batch) -> Motions:
        scene = made.encoder(data.views(made.settings.view, batch))
        return made.draw(scene, batch.start, random)

    return draw


@torch.no_grad()
def evaluate(data: Dataset, draw: Draw, networks_of_fid: dict[int, erd.Erd], rows: np.ndarray, real: torch.Tensor,
             seed: int) -> dict:  # fmt: skip
    """Return the measures of a generator for the pairs ``rows``, with collisions in one random frame of each."""
    random = torch.Generator().manual_seed(seed)
    seen, counts, rooms = [], {radius: [] for radius in measures.RADII}, []
    behaviour: list[dict[str, float]] = []
    for at in range(0, len(rows), BATCH):
        batch = data.batch(torch.as_tensor(rows[at : at + BATCH]))
        made = draw(batch)
        seen.append(erd.frames(made))
        behaviour.append(measures.behaviour(made, batch.start) | {"count": len(batch.start)})
        frames = torch.randint(1, 65, (len(batch.start),), generator=random)
        for radius, found in measures.collisions(
            made, batch.start, data.pictures("depth", batch), frames
        ).items():
            counts[radius].append(found)
        rooms.append(data.small["room_of_picture"][data.small["pairs"][batch.pairs, 0].long()])
    room = torch.cat(rooms).numpy()
    weights = np.array([row["count"] for row in behaviour])
    mean = lambda name: float(np.average([row[name] for row in behaviour], weights=weights))
    collided = {radius: torch.cat(found) for radius, found in counts.items()}
    return {
        "fid": measures.motion_fid(networks_of_fid, real, torch.cat(seen)),
        "non_collision": {f"{1000 * r:.0f} mm": interval(found, room, seed) for r, found in collided.items()},
        "behaviour": {name: mean(name) for name in ("sits_down", "walks", "stays", "way_m")},
    }


def interval(counts: torch.Tensor, rooms: np.ndarray, seed: int) -> list[float]:
    """Return the non-collision rate and its 95 % interval, by resampling rooms."""
    random, numbers = np.random.default_rng(seed), np.unique(rooms)
    by_room = {n: counts[torch.as_tensor(rooms == n)] for n in numbers}
    drawn = [
        measures.non_collision(torch.cat([by_room[n] for n in random.choice(numbers, len(numbers))]))
        for _ in range(RESAMPLED if len(numbers) > 1 else 1)
    ]
    return [measures.non_collision(counts), *(float(v) for v in np.percentile(drawn, [2.5, 97.5]))]


@torch.no_grad()
def spread_over_time(data: Dataset, draw: Draw, seed: int) -> list[float]:
    """Return the mean standard deviation, metres, of samples with the same ends, at every eighth frame (figure 7)."""
    random = np.random.default_rng(seed)
    starts, samples = SPREAD_OF
    found = []
    for pair in random.choice(len(data), min(starts, len(data)), replace=False):
        batch = data.batch(torch.full((samples,), int(pair)))
        found.append(measures.spread(draw(batch).root))
    return [round(float(v), 4) for v in torch.stack(found).mean(0)[::8]]


def text(tables: dict[str, dict]) -> str:
    """Return tables 1, 2 and 4 as one Markdown table."""
    lines = ["| row | FID short | mid | long | mean | 30 mm | 45 mm | 60 mm | sits down | walks | stays |",
             "|" + "---|" * 11]  # fmt: skip
    for name, row in tables.items():
        fid = " | ".join(f"{row['fid'][k]:.2f}" for k in ("short", "mid", "long", "mean"))
        free = " | ".join("{:.3f} ({:.3f} to {:.3f})".format(*v) for v in row["non_collision"].values())
        does = " | ".join(f"{row['behaviour'][k]:.2f}" for k in ("sits_down", "walks", "stays"))
        lines.append(f"| {name} | {fid} | {free} | {does} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--erd", type=Path, required=True)
    parser.add_argument("--run", action="append", required=True, metavar="NAME=FOLDER")
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument(
        "--real", type=int, help="captured windows that are compared with (default: half of them)"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    torch.set_num_threads(1)
    data, judged = dataset.load(options.data), erd.load(options.erd)
    random = np.random.default_rng(options.seed)
    order = random.permutation(len(data))
    half = order[: len(order) // 2][: options.real]
    rows = random.choice(order[len(order) // 2 :], options.frames)
    real = torch.cat([
        erd.frames(data.batch(torch.as_tensor(half[at : at + BATCH])).motions) for at in range(0, len(half), BATCH)
    ])  # fmt: skip
    tables = {"captured": evaluate(data, lambda batch: batch.motions, judged, rows, real, options.seed)}
    for run in options.run:
        name, _, folder = run.partition("=")
        draw = drawing(networks.load(Path(folder)), data, options.seed)
        tables[name] = evaluate(data, draw, judged, rows, real, options.seed)
        tables[name]["spread_m"] = spread_over_time(data, draw, options.seed)
        options.output.write_text(json.dumps(tables, indent=1))
        print(text({name: tables[name]}), flush=True)
    print(text(tables))


if __name__ == "__main__":
    main()
