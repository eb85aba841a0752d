"""Ten steps in a row between a chair, an armchair, a bed and free places: how many steps hold at the first attempt.

python -m samp_blender.benchmarks.chains [--rooms 5] [--takes 3] [--seed 0]

A step holds if its first attempt succeeds and breaks no limit of evaluation/guards.py: squats in the air, flights,
gliding seats, hanging feet. Prints a line for each room and step that needs another attempt or has a warning.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import replace

import numpy as np

from ..samp_addon import frames
from ..samp_addon.errors import SampError
from ..samp_addon.evaluation import guards, metrics
from ..samp_addon.evaluation.obstacles import shared
from ..samp_addon.methods.scene_view import SceneView
from ..samp_addon.methods.step import Step
from ..samp_addon.methods.take import Take
from ..samp_addon.pipeline import driver
from ..samp_addon.pipeline.driver import Work
from ..samp_addon.pipeline.job import Job
from ..samp_addon.scene.geometry import SceneGeometry
from ..tests.support import rooms

FIRST_ROOM = 9000
CHAIN = ("Chair", "", "Bed", "Armchair", "", "Bed", "Chair", "Armchair", "", "Chair")
"""Target of each step; none for a walk back to where the character started."""

FREE = 0.7
"""Metres free of other pieces in front of a seat."""


def works(seed: int, takes: int) -> Work:
    """Return the work of one room. Raise ValueError where the seats find no place in it."""
    room = rooms.random_room(seed, rooms.bed)
    rng = np.random.default_rng(seed)
    kept = room.pieces[:3]
    seats = []
    for make in (rooms.chair, rooms.armchair):
        seats.append(_placed(make.__name__.capitalize(), make(rng), kept + seats, room.start, rng))
    pieces = {"Bed": room.target, **{seat.name: seat for seat in seats}}
    others = [(piece.name, piece.triangles) for piece in kept[1:]]
    named = [("Floor", room.floor), *((name, piece.triangles) for name, piece in pieces.items()), *others]
    geometry = SceneGeometry.from_objects(named)
    views, steps = [], []
    for name in CHAIN:
        if name:
            views.append(SceneView(geometry, pieces[name].triangles, (name,)))
            steps.append(Step("lie" if name == "Bed" else "sit", target=name))
        else:
            views.append(SceneView(geometry, destination=(room.start, None)))
            steps.append(Step("walk", to=tuple(room.start)))
    views[0] = replace(views[0], start=(room.start, room.start_yaw))
    job = Job(action="sit", target=CHAIN[0], seed=100 * seed, variants=takes, then=tuple(steps[1:]))
    return Work(job, views)


def _placed(
    name: str, boxes: list, others: list[rooms.Piece], start: np.ndarray, rng: np.random.Generator
) -> rooms.Piece:
    """Return a seat in a free place, with free floor in front of it."""
    limit = rooms.SIZE / 2 - 1.0
    for _ in range(2000):
        piece = rooms.Piece(name, boxes, rng.uniform(-limit, limit, 2), float(rng.uniform(-np.pi, np.pi)))
        radius = float(np.linalg.norm(piece.half))
        ahead = piece.at + frames.yaw_direction(piece.yaw)[[0, 2]] * (piece.half[1] + FREE / 2)
        near = lambda point, other, gap: (np.linalg.norm(point - other.at) < np.linalg.norm(other.half) + gap)
        blocked = any(near(piece.at, o, radius + 0.3) or near(ahead, o, FREE) for o in others)
        if not blocked and np.linalg.norm(piece.at - start[[0, 2]]) > radius + 0.6:
            return piece
    raise ValueError(f"no free place for the {name.lower()}")


def faults(take: Take, triangles: np.ndarray) -> list[str]:
    """Return the limits that a step breaks, and whether it fails."""
    numbers = metrics.measure(take.motion, take.goal, shared(triangles), take.floor)
    return guards.broken(numbers) + ([] if numbers["success"] else ["fails"])


def main() -> int:
    """Print the steps that do not hold, and the sums; the exit status is 1 where less than 95 % hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", type=int, default=5)
    parser.add_argument("--takes", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    asked = first = final = whole = 0
    seen: Counter[str] = Counter()
    for number in range(options.rooms):
        seed = FIRST_ROOM + options.seed + number
        try:
            work = works(seed, options.takes)
            takes, _ = driver.run(work)
        except (SampError, ValueError) as error:
            print(f"room {seed}: {error}", flush=True)
            takes = []
        asked += options.takes * len(CHAIN)
        for take in takes:
            found = [faults(step, work.views[0].geometry.triangles) for step in take.steps]
            held = [not f and step.attempts == 1 for f, step in zip(found, take.steps, strict=True)]
            first, final = first + sum(held), final + sum(not f for f in found)
            whole += all(held)
            for k, (f, step) in enumerate(zip(found, take.steps, strict=True)):
                seen.update(f)
                if f or step.attempts > 1:
                    what = CHAIN[k] or "walk"
                    print(
                        f"room {seed}, seed {take.seed}, step {k + 1} ({what}): {step.attempts} attempts, {f}"
                    )
        print(f"room {seed}: {len(takes)} takes", flush=True)
    print(f"{asked} steps: {first} hold at the first attempt, {final} after up to three")
    print(f"{whole} of {options.rooms * options.takes} chains hold without another attempt")
    print(", ".join(f"{name}: {count}" for name, count in sorted(seen.items())) or "no limit is broken")
    return int(first < 0.95 * asked)


if __name__ == "__main__":
    sys.exit(main())
