"""Check by an independent computation whether takes with physically impossible motion have a warning.

python -m samp_blender.benchmarks.guards [--takes 200] [--furniture FOLDER] [--seed 0]

The takes are sits, lies and three-step takes (sit, walk away, sit again) on procedural pieces and on training pieces of
the library. Squats in the air, flights and gliding seats are detected with brute_force.py. The exit status is 1 where a
take exceeds a limit without a warning.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..samp_addon.errors import SampError
from ..samp_addon.evaluation import guards, metrics
from ..samp_addon.evaluation.obstacles import shared
from ..samp_addon.methods.step import Step
from ..samp_addon.methods.take import Take
from ..samp_addon.pipeline import driver
from ..samp_addon.pipeline.driver import Work
from ..samp_addon.pipeline.job import Job
from ..tests.support import rooms
from ..training import furniture
from ..training.evaluation.takes import LONG_ENOUGH, SEATS, view_of
from . import brute_force

FIRST_ROOM = 7000
EACH = 4
"""Takes of a job."""

KINDS = ("sit", "lie", "chain")
LIMITS = {"air_squat": 1.0, "flight": 0.25, "glide": 0.6}
TOLERANCE = 1.15
"""Factor on the limits, since both computations sample frames and points and may differ near a limit."""


def works(kind: str, folder: Path, seed: int) -> Work:
    """Return the work of one job of a kind, in the room of a seed."""
    rng = np.random.default_rng(seed)
    action = "lie" if kind == "lie" else "sit"
    pieces = [furniture.generate(category, rng) for category in SEATS[action]]
    if folder.is_dir():
        pieces += [p for p in furniture.load(folder, held_out=False) if p.category in SEATS[action]]
    if action == "lie":
        pieces = [p for p in pieces if np.ptp(p.triangles, axis=(0, 1)).max() >= LONG_ENOUGH]
    piece = pieces[int(rng.integers(len(pieces)))]
    stand_in = rooms.bed if action == "lie" else rooms.sofa
    room = rooms.random_room(FIRST_ROOM + seed, stand_in)
    view = view_of(room, piece)
    job = Job(action=action, target="Target", seed=100 * seed, variants=EACH)
    if kind != "chain":
        return Work(job, [view])
    away = replace(view, target=None, parts=(), start=None, destination=(room.start, None))
    job = replace(job, then=(Step("walk", to=(0.0, 0.0, 0.0)), Step("sit", target="Target")))
    return Work(job, [view, away, replace(view, start=None)])


def broken(take: Take, triangles: np.ndarray) -> dict[str, float]:
    """Return the limits that a take exceeds by the independent computation, with the values."""
    found = brute_force.support(take.motion, triangles, take.floor)
    values = {name: getattr(found, name) for name in LIMITS}
    return {name: value for name, value in values.items() if value > TOLERANCE * LIMITS[name]}


def main() -> int:
    """Print a line for each take that exceeds a limit or has a warning, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--takes", type=int, default=200)
    parser.add_argument("--furniture", type=Path, default=furniture.library.DEFAULT_FOLDER)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    count, unmarked, marked, faults = 0, 0, 0, Counter()
    room = options.seed
    while count < options.takes:
        kind = KINDS[room % len(KINDS)]
        work = works(kind, options.furniture, room)
        room += 1
        try:
            takes, _ = driver.run(work)
        except SampError as error:
            print(f"room {room - 1}, {kind}: {error}", flush=True)
            continue
        triangles = work.views[0].geometry.triangles
        for take in takes:
            numbers = metrics.measure(take.motion, take.goal, shared(triangles), take.floor)
            limits = [name for name in guards.broken(numbers) if name != "hanging_feet_cm"]
            found = broken(take, triangles)
            count += 1
            marked += bool(limits)
            faults.update(found.keys())
            missed = bool(found) and not limits
            unmarked += missed
            if found or limits:
                values = ", ".join(f"{name} {value:.2f}" for name, value in found.items()) or "nothing found"
                reported = ", ".join(f"{name} {numbers[name]:.2f}" for name in limits) or "no warning"
                print(f"room {room - 1}, {kind}, seed {take.seed}: {values}; {reported}", flush=True)
    print(f"{count} takes, {marked} with warnings of support, {unmarked} that exceed a limit without one")
    print(", ".join(f"{name}: {number}" for name, number in sorted(faults.items())) or "no faults")
    return int(unmarked > 0)


if __name__ == "__main__":
    sys.exit(main())
