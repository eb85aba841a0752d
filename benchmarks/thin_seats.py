"""Depth of sits on held-out furniture before and after refinement.

python -m samp_blender.benchmarks.thin_seats --furniture FOLDER [--takes 1] [--categories chair stool bench] [--check 4]

By default, pieces that may be used for choices are measured; --pieces final selects those reserved for final tables.
--check compares the depths of some frames with those by winding numbers (brute_force.py).
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..samp_addon.body import human
from ..samp_addon.errors import SampError
from ..samp_addon.evaluation import collision, metrics
from ..samp_addon.pipeline import driver
from ..samp_addon.pipeline.driver import Work
from ..samp_addon.pipeline.job import Job
from ..samp_addon.refine.refinement import Settings, Surroundings, refine
from ..tests.support import rooms
from ..training.evaluation.takes import held_out_seats, view_of
from . import brute_force


def deepest(motion, around: Surroundings, floor: float) -> np.ndarray:
    """Return the depth (T,), metres: the larger of body in scene and scene in body."""
    solid = collision.body_depth(motion, around.obstacles, floor)[0].max(1)
    return np.maximum(solid, collision.surface_depth(motion, around.obstacles, floor))


def disagreement(motion, around: Surroundings, floor: float, count: int) -> float:
    """Return the largest difference, cm, between the surface's depth in the body and that by winding numbers.

    It is measured in the ``count`` deepest frames and as many others.
    """
    order = np.argsort(collision.surface_depth(motion, around.obstacles, floor))
    rows = np.unique([*order[-count:], *order[:: max(1, len(order) // count)][:count]])
    worst = 0.0
    for row in rows:
        single = motion.pose_slice(np.array([row]))
        skin = human.skin(human.load(), single)[0].astype(np.float64)
        reported = collision.surface_depth(single, around.obstacles, floor)[0]
        worst = max(worst, abs(reported - brute_force.depth(skin, around.triangles, floor)))
    return 100 * worst


def main() -> int:
    """Print a line for each take and the sums; return the exit status, 1 where refined takes are too deep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--furniture", type=Path, required=True)
    parser.add_argument("--takes", type=int, default=1)
    parser.add_argument("--categories", nargs="+", default=["chair", "stool", "bench", "armchair"])
    parser.add_argument("--pieces", choices=["tuning", "final", "all"], default="tuning")
    parser.add_argument("--check", type=int, default=0, help="frames of each take to compare")
    parser.add_argument("--names", nargs="*", help="names of the only pieces to measure")
    parser.add_argument("--thin", type=float, default=1.0, help="weight of the energy of thin objects")
    options = parser.parse_args()
    pieces = [
        p for p in held_out_seats(options.furniture, part=options.pieces) if p.category in options.categories
    ]
    both = [[], []]
    for number, piece in enumerate(pieces):
        if options.names and piece.name not in options.names:
            continue
        view = view_of(rooms.random_room(3000 + number, rooms.sofa), piece)
        job = Job(action="sit", target="Target", seed=7000 + 10 * number, variants=options.takes)
        try:
            takes, _ = driver.run(Work(job, [replace(view)]))
        except SampError as error:
            print(f"{piece.name}: {error}", flush=True)
            continue
        for take in takes:
            around = Surroundings(view.geometry.triangles, np.zeros(len(view.geometry)), take.floor)
            begun = time.perf_counter()
            made = refine(
                take.motion, around, take.goal, settings=Settings(thin=options.thin), measured=False
            )
            seconds = time.perf_counter() - begun
            depths = [100 * deepest(motion, around, take.floor) for motion in (take.motion, made.motion)]
            for all_, depth in zip(both, depths, strict=True):
                all_.append(depth)
            shown = ", ".join(
                f"> 2 cm {100 * (d > 2).mean():.0f} %, > 5 cm {100 * (d > 5).mean():.0f} %, max {d.max():.1f} cm"
                for d in depths
            )
            off = [metrics.position_error(motion, take.goal) for motion in (take.motion, made.motion)]
            line = f"{piece.name} {take.seed}: {shown}; PE {off[0]:.1f}, {off[1]:.1f} cm; "
            if options.check:
                worst = disagreement(made.motion, around, take.floor, options.check)
                line += f"off winding numbers by {worst:.2f} cm; "
            print(f"{line}{seconds:.1f} s for {take.motion.seconds:.1f} s", flush=True)
    if not both[0]:
        return 1
    sums = [np.concatenate(depths) for depths in both]
    for name, d in zip(("before", "after"), sums, strict=True):
        print(
            f"{name}: {100 * (d > 2).mean():.2f} % deeper than 2 cm, {100 * (d > 5).mean():.2f} % than 5 cm"
        )
    return int((sums[1] > 0.02 * 100).mean() > 0.01 or (sums[1] > 5).any())


if __name__ == "__main__":
    sys.exit(main())
