"""Compute the paper's measures on held-out furniture: tables for each action, and comparisons of networks.

python -m samp_blender.training.evaluate --rooms 34 --takes 3 --actions sit
python -m samp_blender.training.evaluate --actions sit --versions MotionNet=models/weights MLP=RUN:mlp --no-planner
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

from ..samp_addon.methods.samp import goals
from ..samp_addon.methods.samp.load_networks import MotionNetwork, load_motion_net
from ..samp_addon.methods.samp.networks import Networks
from ..samp_addon.methods.samp.rollout import generator
from ..samp_addon.motion import Motion
from . import furniture
from .evaluation import corrections, reference, refined, report, rows, sheets, stages
from .evaluation.takes import SEATS, evaluate, held_out_seats, jobs_of

SHARED = Path(__file__).resolve().parent.parent.parent / "shared" / "data"
SHEETS = 20
TABLES = ("takes", "stages", "corrections")


def network_of(version: str) -> tuple[str, MotionNetwork]:
    """Parse NAME=FOLDER or NAME=FOLDER:NETWORK, a folder with motion_net.safetensors; return name and network."""
    name, _, place = version.partition("=")
    folder, _, kind = place.partition(":")
    return name, load_motion_net(Path(folder), kind or "motion_net")


def with_goals(network: MotionNetwork) -> Networks:
    """Return the networks of SAMP with the shipped GoalNet and this MotionNet."""
    return Networks(goals.sample_goals, partial(generator.generate, network=network))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rooms", type=int, default=12)
    parser.add_argument("--takes", type=int, default=3)
    parser.add_argument("--actions", nargs="+", default=["sit", "lie", "walk", "run"])
    parser.add_argument("--furniture", type=Path, default=furniture.available(SHARED / "furniture"))
    parser.add_argument("--mocap", type=Path, default=SHARED / "mocap" / "test")
    parser.add_argument(
        "--versions",
        nargs="+",
        metavar="NAME=FOLDER[:NETWORK]",
        help="compare networks; NETWORK is motion_net, mlp or moe",
    )
    parser.add_argument(
        "--no-planner", action="store_true", help="with --versions: add the first one without the planner"
    )
    parser.add_argument(
        "--sheets", type=Path, help="folder for contact sheets of 20 random takes of each action"
    )
    parser.add_argument(
        "--refine", action="store_true", help="refine each take and print the measures before and after"
    )
    parser.add_argument(
        "--pieces",
        choices=["tuning", "final", "all"],
        default="tuning",
        help="held-out pieces: those that may be used for choices, or the third reserved for final tables",
    )
    parser.add_argument(
        "--tables",
        nargs="+",
        choices=TABLES,
        default=TABLES[:2],
        help="takes: as in the extension; stages: network alone, guided, finished; corrections: finishing without each "
        "correction in turn. With --versions: takes and stages",
    )
    parser.add_argument(
        "--network", type=Path, help="folder of MotionNet weights, instead of the shipped ones"
    )
    options = parser.parse_args(arguments)
    versions = {name: rows.Version(network) for name, network in map(network_of, options.versions or [])}
    if options.no_planner and versions:
        name, version = next(iter(versions.items()))
        versions[f"{name}, no planner"] = version._replace(planner=False)
    if options.furniture == furniture.library.SHIPPED_FOLDER:
        print(furniture.missing(SHARED / "furniture"))
    if not options.mocap.is_dir():
        print(f"{options.mocap} is missing, so the tables have no measures of captured motion.")
    pace = reference.real_pace([options.mocap, options.mocap.parent / "smplx30"])
    for action in options.actions:
        pieces = held_out_seats(options.furniture, action, options.pieces)
        if action in SEATS:
            names = ", ".join(piece.name for piece in pieces)
            print(
                f"{action}: {len(pieces)} held-out pieces ({options.pieces}): {names}"
                if pieces
                else f"{action}: boxes"
            )
        real = reference.real_motion(options.mocap, action)
        tables = (
            _compared(action, pieces, real, options, versions)
            if versions
            else _tables(action, pieces, real, pace, options)
        )
        print("\n\n".join(tables), flush=True)
    return 0


def _compared(
    action: str,
    pieces: Sequence[furniture.piece.Piece],
    real: Sequence[Motion],
    options: argparse.Namespace,
    versions: Mapping[str, rows.Version],
) -> Iterator[str]:
    """Yield the requested tables of an action, for several networks."""
    if "takes" in options.tables:
        networks = {name: version.adapted(with_goals(version.network)) for name, version in versions.items()}
        made = partial(evaluate, action, options.rooms, options.takes, pieces)
        yield report.comparison(action, {name: made(of) for name, of in networks.items()}, real)
    if "stages" in options.tables:
        yield rows.table(
            action, rows.measure(jobs_of(action, options.rooms, options.takes, pieces), versions)
        )


def _tables(
    action: str,
    pieces: Sequence[furniture.piece.Piece],
    real: Sequence[Motion],
    pace: tuple[float, float] | None,
    options: argparse.Namespace,
) -> Iterator[str]:
    """Yield the requested tables of an action, for one network."""
    network = load_motion_net(options.network) if options.network else None
    networks = with_goals(network) if network else None
    if "takes" in options.tables or options.refine or options.sheets:
        results = evaluate(action, options.rooms, options.takes, pieces, networks)
        yield report.table(action, results, real, pace if action == "sit" else None)
        if options.refine:
            pairs = zip(results.takes, results.scenes, strict=True)
            yield refined.table(action, [refined.mend(take, scene) for take, scene in pairs])
        if options.sheets is not None:
            sheets.draw(action, results, options.sheets, SHEETS)
    jobs = jobs_of(action, options.rooms, options.takes, pieces)
    if "stages" in options.tables:
        yield stages.table(action, stages.measure(jobs, network))
    if "corrections" in options.tables:
        yield corrections.table(action, corrections.measure(jobs, network))


if __name__ == "__main__":
    sys.exit(main())
