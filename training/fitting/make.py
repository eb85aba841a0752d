"""Build the fitted sits and lies of MotionNet's training set, and a file of their pieces next to it.

python -m samp_blender.training.fitting.make --mocap FOLDER ... --furniture FOLDER --output fitted.npz
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..composition import long_sits
from ..composition.recline import reclines
from ..composition.sequence import Sequence, save
from ..composition.stitch import WalkIndex
from ..mocap import natural, sources
from ..mocap.clip_files import Clip
from ..mocap.events import SitEvent, sit_events
from ..mocap.posture import neutralised
from .lying.lies import FittedLies
from .provenance import total
from .shapes import pieces as furnishing
from .shapes.kept import keep, kept
from .shapes.piece_file import read_pieces, write_pieces
from .sits import FittedComposer, trimmed

SELDOM = 2  # Rocketbox's composed sits, several for each captured one, are tried in every SELDOM-th round
STRIDE = 4  # stride, in frames, of the walks' frames to which sits are joined


def captured(folders: list[Path], chains: int, seed: int) -> tuple[list[Clip], WalkIndex, list[SitEvent]]:
    """Return the clips in the neutral posture, the index of their walks by pose, and their sits."""
    clips = neutralised(sources.load(folders))
    walks = [natural.astray_marked(c) for c in clips if sources.walks(c)]
    sitting = clips + long_sits.long_sits(clips, chains, np.random.default_rng(seed))
    return clips, WalkIndex(walks, stride=STRIDE), [event for clip in sitting for event in sit_events(clip)]


def balanced(sequences: list[Sequence]) -> list[Sequence]:
    """Return the sequences with weights, so that a piece counts as the square root of its number of sequences."""
    counts = Counter((s.kind, s.piece) for s in sequences)
    weights = {key: count**-0.5 for key, count in counts.items()}
    mean = sum(weights[s.kind, s.piece] for s in sequences) / max(len(sequences), 1)
    return [replace(s, weight=weights[s.kind, s.piece] / mean) for s in sequences]


def sits(composer: FittedComposer, events: list[SitEvent], rounds: int, began: float) -> list[Sequence]:
    """Return the sequences from ``rounds`` tries of every captured sit, in random order."""
    sequences: list[Sequence] = []
    for number in range(rounds):
        for k in composer.rng.permutation(len(events)):
            if not (events[k].clip.name.startswith("rb_") and number % SELDOM):
                sequences += composer.compose(events[k])
        print(f"round {number}: {len(sequences)} sits, {_since(began)}", flush=True)
    return sequences


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mocap", type=Path, nargs="+", required=True)
    parser.add_argument("--furniture", type=Path)
    parser.add_argument("--output", type=Path, default=Path("cache/fitted.npz"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sits", type=int, default=8, help="fits to try for each captured sit")
    parser.add_argument("--lies", type=int, default=400, help="sequences of lying down to try")
    parser.add_argument(
        "--chains", type=int, default=4, help="long sits composed from each Rocketbox clip of sitting down"
    )
    parser.add_argument("--share", type=float, default=1.0, help="share of the furniture, for quick trials")
    parser.add_argument("--pieces", type=Path, help="earlier training set whose pieces are used instead")
    parser.add_argument("--categories", nargs="+", help="only pieces of these categories")
    parser.add_argument(
        "--trim",
        action="store_true",
        help="cut off the walks to and from a seat, which may lead through sofas",
    )
    parser.add_argument("--kept", type=Path, help="folder in which clips and pieces are cached between runs")
    options = parser.parse_args()
    began = time.time()
    clips, walks, events = kept(
        options.kept, "captured", lambda: captured(options.mocap, options.chains, options.seed)
    )
    if options.trim:
        events = [trimmed(event) for event in events]
    prepare = lambda: _ready(_pieces(options))
    pieces = kept(options.kept, "pieces", prepare)
    print(f"{len(events)} sits, {len(pieces)} pieces, {_since(began)}", flush=True)
    composer = FittedComposer(pieces, walks, options.seed, *([0] if options.trim else []))
    sequences = sits(composer, events, options.sits, began)
    lying = FittedLies(pieces, events, reclines(clips), composer.captured.approach, options.seed)
    sequences += [lie for lie in (lying.compose() for _ in range(options.lies)) if lie is not None]
    save(options.output, balanced(sequences), furnishing.grids(pieces), mirrored=True)
    write_pieces(options.output, pieces)
    keep(options.kept, "pieces", pieces)  # with the distances computed during fitting
    for kind, reports, counts in (
        ("sit", [composer.report], composer.owed),
        ("lie", [*(c.report for c in lying.composers.values()), lying.report], lying.owed),
    ):
        lengths = [len(s) for s in sequences if s.kind == kind]
        print(f"{kind}: {len(lengths)} sequences, {sum(lengths) / 1800:.1f} minutes")
        print("as captured:", {name: round(share, 3) for name, share in total(counts).items()})
        for report in reports:
            print(", ".join(f"{why} {count}" for why, count in report.most_common()))
    print(f"{options.output} in {_since(began)}")


def _pieces(options: argparse.Namespace) -> list[furnishing.FittingPiece]:
    """Return the pieces of an earlier set or new ones; places to sit and lie only on the wanted categories."""
    if options.pieces is None:
        pieces = furnishing.collect(options.furniture, options.seed, options.share)
    else:
        pieces = read_pieces(options.pieces)
    if options.categories:
        for piece in pieces:
            if piece.category not in options.categories:
                piece.__dict__.update(seats=[], beds=[])
    return pieces


def _ready(pieces: list[furnishing.FittingPiece]) -> list[furnishing.FittingPiece]:
    """Return the pieces with their seats and beds computed."""
    for piece in pieces:
        _ = piece.seats, piece.beds
        piece.__dict__.pop("_map", None)
    return pieces


def _since(began: float) -> str:
    return f"{time.time() - began:.0f} s, {time.process_time():.0f} s of a core"


if __name__ == "__main__":
    main()
