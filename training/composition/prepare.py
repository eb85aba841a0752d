"""Build MotionNet's training set from prepared motion capture and furniture.

python -m samp_blender.training.composition.prepare --mocap FOLDER ... --furniture FOLDER --output cache/motion.npz
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...samp_addon.scene import geometry
from ...samp_addon.scene.seats import seats
from ...samp_addon.scene.voxels import InteractionGrid
from .. import furniture
from ..mocap import natural, sources
from ..mocap.events import sit_events
from ..mocap.posture import neutralised
from .lies import LieComposer
from .long_sits import long_sits
from .other_pieces import other_pieces
from .recline import reclines
from .runs import RunComposer
from .sequence import save
from .sits import Composer, Furnishing
from .stitch import WalkIndex
from .walks import walk_sequence

# Number of procedural pieces of each category, and of scaled copies of each real piece.
PROCEDURAL = {"chair": 40, "armchair": 30, "stool": 20, "bar_stool": 20, "bench": 12, "sofa": 30, "l_sofa": 16,
              "office_chair": 20, "pouf": 12, "table": 12, "bed": 12}  # fmt: skip
COPIES = 3
PLACES = 16  # goals per piece
SHORT = 600  # frames of the longest clips used to compose runs; longer ones contain whole runs
LONG_SITS = 3  # long sits composed from each Rocketbox clip of sitting down, in addition to the original
ROCKETBOX_SITS = 4  # sequences tried for each Rocketbox sit: all start and end in the same few rest poses


def furnishings(
    folder: Path | None, seed: int
) -> tuple[list[Furnishing], list[Furnishing], dict[str, np.ndarray]]:
    """Return the pieces with places to sit, the pieces with places to lie, and the grids of all.

    Grids: centres (P, 512, 3), metres, and occupancy (P, 512).
    """
    rng = np.random.default_rng(seed)
    triangles = [furniture.generate(name, rng).triangles for name, n in PROCEDURAL.items() for _ in range(n)]
    if folder is not None and folder.exists():
        for piece in furniture.load(folder, held_out=False):
            if "table" in piece.category or "desk" in piece.category:
                continue
            triangles += [piece.triangles * rng.uniform(0.9, 1.12, 3) for _ in range(COPIES)]
    chairs, beds, centres, occupancy = [], [], [], []
    for mesh in triangles:
        grid = InteractionGrid.build(mesh, yaw=0.0)
        surface, _ = geometry.sample_surface(mesh, 4000, seed=0)
        places = seats.support_map(mesh, floor_height=0.0)
        for pieces, action in ((chairs, "sit"), (beds, "lie")):
            goals = [seat.goal for seat in seats.seats_on_map(places, action, PLACES)]
            pieces.append(Furnishing(len(pieces), surface, goals))
        centres.append(grid.centres)
        occupancy.append(grid.occupancy)
    return (
        chairs,
        beds,
        {"centres": np.array(centres, np.float32), "occupancy": np.array(occupancy, np.float32)},
    )


def build(
    mocap_folders: list[Path],
    furniture_folder: Path | None,
    seed: int,
    sits_per_event: int,
    lies: int,
    runs: int,
    plain: bool = False,
) -> tuple:
    """Return all sequences, the pieces' grids, and for each action a report of how many were kept or dropped, and why.

    Mirror images are added when the file is read. plain: sits stay as captured, for the ablation without augmentation.
    """
    rng = np.random.default_rng(seed)
    clips = neutralised(sources.load(mocap_folders))
    walks = [natural.astray_marked(c) for c in clips if sources.walks(c)]
    sequences = [
        replace(walk_sequence(c, rng), weight=sources.weight(c.name))
        for c in walks
        if len(c) > 75 and natural.on_foot(c)
    ]
    running = RunComposer([c for c in walks if len(c) <= SHORT], seed)
    made = (running.compose() for _ in range(runs))
    sequences += [walk_sequence(clip, rng) for clip in made if clip is not None]
    chairs, beds, grids = furnishings(furniture_folder, seed)
    sitting = clips if plain else clips + long_sits(clips, LONG_SITS, rng)
    events = [event for clip in sitting for event in sit_events(clip)]
    composer = Composer([p for p in chairs if p.goals], WalkIndex(walks), seed, plain)
    for event in events:
        tries = ROCKETBOX_SITS if event.clip.name.startswith("rb_") else sits_per_event
        made = (composer.compose(event) for _ in range(tries))
        sequences += [replace(s, more=other_pieces(s, composer.seats, rng)) for s in made if s is not None]
    lying = LieComposer([p for p in beds if p.goals], events, reclines(clips), composer.approach, seed)
    made = (lying.compose() for _ in range(lies))
    sequences += [s for s in made if s is not None]
    return sequences, grids, {"runs": running.report, "sits": composer.report, "lies": lying.report}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mocap", type=Path, nargs="+", required=True, help="folders of clips")
    parser.add_argument("--furniture", type=Path)
    parser.add_argument("--output", type=Path, default=Path("cache/motion.npz"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sits", type=int, default=16, help="sequences to try for each captured sit")
    parser.add_argument("--lies", type=int, default=900, help="number of sequences of lying down to try")
    parser.add_argument("--runs", type=int, default=260, help="number of runs to try")
    parser.add_argument(
        "--plain", action="store_true", help="ablation: no augmentation; use --lies 0 --runs 0"
    )
    options = parser.parse_args()
    began = time.time()
    sequences, grids, reports = build(
        options.mocap,
        options.furniture,
        options.seed,
        options.sits,
        options.lies,
        options.runs,
        options.plain,
    )
    save(options.output, sequences, grids, mirrored=not options.plain)
    for kind in sorted({s.kind for s in sequences}):
        frames = sum(len(s) for s in sequences if s.kind == kind)
        print(f"{kind}: {sum(s.kind == kind for s in sequences)} sequences, {frames / 1800:.1f} minutes")
    for action, report in reports.items():
        print(f"{action}:", ", ".join(f"{why} {n}" for why, n in report.most_common()))
    print(f"{options.output}: {options.output.stat().st_size / 1e6:.1f} MB in {time.time() - began:.0f} s")


if __name__ == "__main__":
    main()
