"""Builds the fitted sits and lies of MotionNet's training set.

python -m samp_blender.training.fitting.make --mocap FOLDER ... --furniture FOLDER --output fitted.npz
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from ..mocap import Clip
from ..motion import natural
from ..motion.events import SitEvent, sit_events
from ..motion.posture import neutralised
from ..motion.recline import reclines
from ..motion.sequence import Sequence, save
from ..motion.stitch import WalkIndex
from ..sets import seated, sources
from .lies import FittedLies
from .provenance import total
from .shapes import pieces as furnishing
from .shapes.kept import keep, kept
from .sits import FittedComposer

SELDOM = 2  # Rocketbox's chained sits, several for each captured one, are tried every so many rounds
STRIDE = 4  # frames between two of a walk that others are joined to


def captured(folders: list[Path], chains: int, seed: int) -> tuple[list[Clip], WalkIndex, list[SitEvent]]:
    """The clips in one posture, their walks by pose, and the sits in them."""
    clips = neutralised(sources.load(folders))
    walks = [natural.astray_marked(c) for c in clips if sources.walks(c)]
    sitting = clips + seated.long_sits(clips, chains, np.random.default_rng(seed))
    return clips, WalkIndex(walks, stride=STRIDE), [event for clip in sitting for event in sit_events(clip)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mocap", type=Path, nargs="+", required=True)
    parser.add_argument("--furniture", type=Path)
    parser.add_argument("--output", type=Path, default=Path("cache/fitted.npz"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sits", type=int, default=8, help="sequences tried for each captured sit")
    parser.add_argument("--lies", type=int, default=400, help="sequences of lying down tried")
    parser.add_argument(
        "--chains", type=int, default=4, help="chained sits for each of Rocketbox's sit-downs"
    )
    parser.add_argument("--share", type=float, default=1.0, help="of the furniture, for quick trials")
    parser.add_argument("--kept", type=Path, help="folder for what is slow to make and the same in every run")
    options = parser.parse_args()
    began = time.time()
    clips, walks, events = kept(
        options.kept, "captured", lambda: captured(options.mocap, options.chains, options.seed)
    )
    pieces = kept(
        options.kept,
        "pieces",
        lambda: _ready(furnishing.collect(options.furniture, options.seed, options.share)),
    )
    composer = FittedComposer(pieces, walks, options.seed)
    events = [events[k] for k in np.random.default_rng(options.seed).permutation(len(events))]
    print(
        f"{len(events)} sits, {len(pieces)} pieces, {len(composer.seats)} seats, {_since(began)}", flush=True
    )
    grids = furnishing.grids(pieces)
    sequences: list[Sequence] = []
    for number in range(options.sits):
        for count, event in enumerate(events):
            if event.clip.name.startswith("rb_") and number % SELDOM:
                continue
            sequences += composer.compose(event)
            if count % 25 == 24 or event is events[-1]:
                save(options.output, sequences, grids, mirrored=True)
                print(
                    f"{number}: {len(sequences)} sits, {_since(began)}, {dict(composer.report)}", flush=True
                )
        keep(options.kept, "pieces", pieces)
        keep(options.kept, "fitted", (sequences, composer.fitted, composer.owed, composer.report))
    lying = FittedLies(pieces, events, reclines(clips), composer.captured.approach, options.seed)
    made = [lie for lie in (lying.compose() for _ in range(options.lies)) if lie is not None]
    save(options.output, sequences + made, grids, mirrored=True)
    print(f"lies: {len(made)}, {_since(began)}", dict(lying.composer.report), dict(lying.report))
    print("lies as captured or composed:", total(lying.owed))
    minutes = sum(len(s) for s in sequences) / 1800
    print(f"sit: {len(sequences)} sequences, {minutes:.1f} minutes")
    print("\n".join(f"{n} {why}" for why, n in composer.report.most_common()))
    print("as captured:", {name: round(share, 3) for name, share in total(composer.owed).items()})
    print(f"{options.output} in {_since(began)}")


def _ready(pieces: list[furnishing.FittingPiece]) -> list[furnishing.FittingPiece]:
    """The pieces with their seats and beds known."""
    for piece in pieces:
        _ = piece.seats, piece.beds
        piece.__dict__.pop("_map", None)
    return pieces


def _since(began: float) -> str:
    return f"{time.time() - began:.0f} s, {time.process_time():.0f} s of a core"


if __name__ == "__main__":
    main()
