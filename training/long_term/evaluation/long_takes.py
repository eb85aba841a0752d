"""Long takes with random sub-goals in test rooms, generated as in the extension.

python -m samp_blender.training.long_term.evaluation.long_takes --corpus cache/rooms --weights RUN --rooms 50

Prints the share of takes within all guarded measures, non-collision, contact, stance slide, and the reasons of
failures. --sub-goals 2, 3 and 4 give takes of about 2, 4 and 6 s of walking. --takes 4 makes takes of four seeds in
each room, and prints how far they differ; --same-bodies draws the bodies at the sub-goals once for all of them, as the
sidebar does.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from pathlib import Path

import numpy as np

from ....samp_addon.errors import SampError
from ....samp_addon.evaluation import collision, diversity, feet, guards, support
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.methods.long_term import networks
from ....samp_addon.methods.long_term.method import LongTerm
from ....samp_addon.methods.long_term.sub_goals import places
from ....samp_addon.methods.long_term.surfaces import Surfaces
from ....samp_addon.methods.method import Draw
from ....samp_addon.methods.scene_view import SceneView
from ....samp_addon.methods.step import Step
from ....samp_addon.motion import Motion
from ....samp_addon.refine import refinement
from ....samp_addon.scene.geometry import SceneGeometry
from ....samp_addon.scene.seats import seats
from ...rooms.corpus.store import Corpus, RoomData
from . import intervals

SEATED = 0.35  # share of the sub-goals that are on furniture
APART = 1.2  # metres between two sub-goals
TRIES = 200


def sub_goals(
    data: RoomData, view: SceneView, count: int, rng: np.random.Generator
) -> list[tuple[np.ndarray, float]]:
    """Return random points on floor, seats and beds with yaws, each at least APART from the previous one, where a body
    has room."""
    room = data.room
    mesh = view.navmesh
    surfaces = Surfaces(room.triangles, mesh)
    low = mesh.points[:, 1] < 0.1  # exclude the roof, which is walkable as well
    free, islands = mesh.points[low], mesh.island_of(mesh.walkable[low])
    free = free[islands == np.bincount(islands).argmax()]
    rests = []
    for item in room.seats:
        piece = room.triangles[room.objects == item]
        try:
            for action in ("sit", "lie"):
                rests += seats.find_goals(piece, action, 0.0, limit=3)
        except SampError:
            continue
    found: list[tuple[np.ndarray, float]] = []
    for _ in range(TRIES):
        if len(found) == count:
            break
        if found and rests and rng.random() < SEATED:
            goal = rests[int(rng.integers(len(rests)))]
            lift = 0.18 if goal.action == "sit" else 0.12
            point = np.asarray(goal.position) - [0.0, lift, 0.0]
            yaw = float(np.arctan2(goal.direction[0], goal.direction[2]))
        else:
            point, yaw = free[int(rng.integers(len(free)))], float(rng.uniform(-np.pi, np.pi))
        if not found or np.linalg.norm((point - found[-1][0])[[0, 2]]) > APART:
            try:
                places.find(surfaces, point, yaw, "It")
            except SampError:  # a chair pushed under a table
                continue
            found.append((point, yaw))
    return found


def _bodies(method: LongTerm, view: SceneView) -> list[Motion]:
    """Return a body for each sub-goal, as the sidebar draws them first."""
    drawing = method.bodies(view)
    return [drawing.draw(drawing.place(point, yaw, "It"), 1, Step.style) for point, yaw in view.sub_goals]


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--corpus", type=Path, required=True)
    parser.add_argument("--weights", type=Path, required=True)
    parser.add_argument("--rooms", type=int, default=50)
    parser.add_argument("--sub-goals", type=int, default=10, help="number of sub-goals of each take")
    parser.add_argument("--takes", type=int, default=1, help="takes of each room, of different seeds")
    parser.add_argument("--same-bodies", action="store_true", help="the takes pass the same bodies")
    parser.add_argument("--optimise", action="store_true")
    parser.add_argument("--split", default="test")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    corpus, method = Corpus(options.corpus), LongTerm(networks.load(options.weights))
    numbers = corpus.rooms(options.split)
    values: dict[str, list[tuple[float, int]]] = {}
    reasons: Counter[str] = Counter()
    for count in range(options.rooms):
        number = numbers[count % len(numbers)]
        data, rng = corpus.room(number), np.random.default_rng([options.seed, count])
        geometry = SceneGeometry.from_objects([("room", data.room.triangles)])
        view = SceneView(geometry)
        view = SceneView(geometry, sub_goals=sub_goals(data, view, options.sub_goals, rng))
        if options.same_bodies:
            view = SceneView(geometry, sub_goals=view.sub_goals, bodies=_bodies(method, view))
        settings = {"sub_goals": tuple((*map(float, p), y) for p, y in view.sub_goals)}
        step = Step(action="", method="long_term", settings=settings, hold=1.0)
        began = time.time()
        draws = [Draw(seed, seed) for seed in range(count, count + options.takes)]
        takes, failures = method.generate(step, view, draws, lambda stage, share: None)
        seconds = (time.time() - began) / len(draws)
        reasons.update(failure.message for failure in failures)
        warned = values.setdefault("finished without a warning", [])
        warned += [(0.0, number)] * len(failures)
        if len(takes) > 1:
            apart = diversity.diversity_in_time([take.motion for take in takes])
            values.setdefault("APD frame by frame", []).append((apart, number))
        obstacles = Obstacles(data.room.triangles)
        for take in takes:
            motion = take.motion
            if options.optimise:
                around = refinement.Surroundings(data.room.triangles, np.zeros(len(data.room.triangles)), 0.0)
                motion = refinement.refine(motion, around, take.goal, measured=False).motion
            depth, touching = collision.body_depth(motion, obstacles, 0.0)
            broken = guards.broken(support.measures(motion, take.goal, obstacles, 0.0))
            reasons.update(map(str, broken))
            warned.append((100 * float(not broken), number))
            numbers_of = {
                "non_collision": 100 * float((depth <= collision.ROUNDING).mean()),
                "contact": 100 * float(touching.any(1).mean()),
                "stance_slide": feet.measures(motion, 0.0)["stance_slide_cm_s"] or 0.0,
                "length_s": motion.seconds,
                "seconds": seconds,
            }
            for name, value in numbers_of.items():
                values.setdefault(name, []).append((value, number))
    for name, rows in values.items():
        print("{}: {:.2f} [{:.2f}, {:.2f}]".format(name, *intervals.mean(*np.array(rows).T)))
    for reason, count in reasons.most_common(12):
        print(f"{count} x {reason}")


if __name__ == "__main__":
    main()
