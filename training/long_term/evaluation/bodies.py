"""Bodies at sub-goals in test rooms: contact, depth and diversity, of single draws and of chosen ones.

python -m samp_blender.training.long_term.evaluation.bodies --corpus cache/rooms --weights RUN --places 200

Places are those of captured standing, sitting and lying bodies, whose pelvis, facing and shape are the conditions.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ....samp_addon.body import betas as shapes
from ....samp_addon.evaluation import collision
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.methods.long_term import networks
from ....samp_addon.methods.long_term.figure import Figure, as_motion
from ....samp_addon.methods.long_term.networks import Wanted
from ....samp_addon.methods.long_term.sub_goals import bodies
from ....samp_addon.methods.long_term.sub_goals.places import Place
from ....samp_addon.methods.long_term.surfaces import Surfaces
from ....samp_addon.scene.navmesh import navmesh
from ...rooms.corpus.store import Corpus, RoomData
from ...rooms.episodes.bank import LABELS
from . import intervals

DRAWS = 20
ACTIONS = {"idle": "idle", "shift": "idle", "sit": "sit", "lie": "lie"}
"""Captured labels and the actions of their places."""


def captured(data: RoomData, count: int, rng: np.random.Generator) -> list[tuple[Place, Figure]]:
    """Return up to ``count`` places of each action, with the captured bodies."""
    labels, bounds = np.array(data.array("motion", "labels")), np.array(data.bounds)
    found = []
    for action in dict.fromkeys(ACTIONS.values()):
        kinds = [LABELS.index(name) for name, other in ACTIONS.items() if other == action]
        rows = np.flatnonzero(np.isin(labels, kinds))
        for row in rng.permutation(rows)[:count]:
            episode = int(np.searchsorted(bounds, row, side="right")) - 1
            motion = data.motion(episode, int(row - bounds[episode]), 1)
            shape = shapes.from_shapes(np.array(data.array("motion", "shapes")[episode]))
            figure = Figure(motion.root[0], motion.rotations[0], np.zeros(24), shape)
            floor = figure.root * [1.0, 0.0, 1.0]
            found.append((Place(action, figure.root, figure.facing(action), floor), figure))
    return found


def measures(figures: Sequence[Figure], obstacles: Obstacles) -> dict[str, float]:
    """Return the shares of bodies in contact and of bodies deeper than 2 cm, percent."""
    body, touches, deep = shapes.body_of(figures[0].betas), [], []
    for (
        figure
    ) in figures:  # one by one: surface_depth looks at some frames only where neighbouring ones are alike
        motion = as_motion([figure])
        depth, touching = collision.body_depth(motion, obstacles, 0.0, body)
        touches.append(touching.any())
        deep.append(max(depth.max(), collision.surface_depth(motion, obstacles, 0.0, body)[0]) > 0.02)
    return {"contact": 100 * float(np.mean(touches)), "deep": 100 * float(np.mean(deep))}


def spread(figures: Sequence[Figure]) -> float:
    """Return the mean distance between the joints of pairs of bodies, pelvis and facing removed, centimetres."""
    joints = np.array([_about(figure) for figure in figures])
    apart = np.linalg.norm(joints[:, None] - joints[None], axis=-1).mean(-1)
    return 100 * float(apart[np.triu_indices(len(figures), 1)].mean())


def _about(figure: Figure) -> np.ndarray:
    cos, sin = np.cos(figure.yaw), np.sin(figure.yaw)
    away = figure.joints - figure.root
    return np.column_stack(
        [away[:, 0] * cos - away[:, 2] * sin, away[:, 1], away[:, 0] * sin + away[:, 2] * cos]
    )


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--corpus", type=Path, required=True)
    parser.add_argument("--weights", type=Path, required=True)
    parser.add_argument("--places", type=int, default=200)
    parser.add_argument("--split", default="test")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    corpus, nets = Corpus(options.corpus), networks.load(options.weights)
    rng = np.random.default_rng(options.seed)
    numbers = corpus.rooms(options.split)
    each = max(options.places // (3 * max(len(numbers), 1)), 1)
    values: dict[str, list[tuple[float, int]]] = {}
    for number in numbers:
        data = corpus.room(number)
        triangles = data.room.triangles
        surfaces, obstacles = Surfaces(triangles, navmesh.build(triangles)), Obstacles(triangles)
        known = captured(data, each, rng)
        for place, figure in known:
            cloud = surfaces.cloud(place.pelvis[None], bodies.AROUND, 0.0, int(rng.integers(2**31)))
            wanted = Wanted(place.action, place.pelvis, place.yaw, 0.0, figure.betas, np.zeros(2))
            noise, turns = networks.body_noise(rng, DRAWS, 1.0), networks.body_turns(rng, DRAWS)
            drawn = nets.sample_bodies(wanted, cloud, noise, turns)
            chosen = bodies.choose(nets, surfaces, place, figure.betas, rng, 1.0)
            found = {"captured": [figure], "drawn": drawn, "chosen": [chosen]}
            for kind, figures in found.items():
                for name, value in measures(figures, obstacles).items():
                    values.setdefault(f"{place.action} {kind} {name}", []).append((value, number))
            values.setdefault(f"{place.action} drawn APD", []).append((spread(drawn), number))
        for action in dict.fromkeys(ACTIONS.values()):
            same = [figure for place, figure in known if place.action == action]
            if len(same) > 1:
                values.setdefault(f"{action} captured APD", []).append((spread(same), number))
    for name, rows in sorted(values.items()):
        print("{}: {:.1f} [{:.1f}, {:.1f}]".format(name, *intervals.mean(*np.array(rows).T)))


if __name__ == "__main__":
    main()
