"""Postures by choice: how many takes rest as asked, and how many of those that were not asked.

python -m samp_blender.benchmarks.postures [--rooms 8] [--seed 0]

Armchairs in rooms of boxes for sits, a chair at a table for hands on the table, beds with a headboard for lies. A take
counts for a posture if it has it in half of its last second (evaluation/rest_posture.py). Takes at places that have no
room for a posture are left out; so are rooms where no way leads to the place.
"""

from __future__ import annotations

import argparse
from collections import defaultdict

import numpy as np

from ..samp_addon.errors import SampError
from ..samp_addon.evaluation import rest_posture
from ..samp_addon.methods.scene_view import SceneView
from ..samp_addon.methods.take import Take
from ..samp_addon.pipeline import driver
from ..samp_addon.pipeline.driver import Work
from ..samp_addon.pipeline.job import Job
from ..samp_addon.scene.geometry import SceneGeometry
from ..samp_addon.vocabulary import POSTURE_NAMES, POSTURES
from ..tests.support import rooms
from . import cast

FIRST_ROOM = 9100
LAST_SECOND = 30
"""Frames."""

HELD = 0.5


def scene(posture: str, seed: int) -> tuple[SceneView, str]:
    """Return a view with a target that has room for a posture, and the target's name."""
    if posture == "hands_on_table":
        geometry, chairs = cast.dining_room(seed)
        return SceneView(geometry, geometry.triangles_of(chairs[:1]), (chairs[0],)), chairs[0]
    make = rooms.bed if posture in POSTURES["lie"] else rooms.armchair
    room = rooms.random_room(seed, make)
    named = [("Floor", room.floor), *((piece.name, piece.triangles) for piece in room.pieces)]
    name = room.target.name
    start = (room.start, room.start_yaw)
    return SceneView(SceneGeometry.from_objects(named), room.target.triangles, (name,), start=start), name


def take(view: SceneView, target: str, action: str, seed: int, posture: str) -> Take | None:
    """Return a take that was asked for a posture, or for none if that is empty; None where there is none."""
    settings = {"posture": posture} if posture else {}
    job = Job(action, target, seed=seed, settings=settings)
    try:
        takes, _ = driver.run(Work(job, [view]))
    except SampError:
        return None
    return takes[0] if takes else None


def rests(made: Take, action: str) -> np.ndarray:
    """Return flags (9,) of the postures that a take has in half of its last second."""
    frames = np.arange(len(made.motion) - LAST_SECOND, len(made.motion))
    return rest_posture.shares(made.motion, action, frames) > HELD


def main() -> None:
    """Print a line for each posture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", type=int, default=8)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    found: dict[str, list[tuple[bool, bool]]] = defaultdict(list)
    for action in ("sit", "lie"):
        for posture in POSTURES[action]:
            at = POSTURE_NAMES.index(posture)
            for number in range(options.rooms):
                seed = FIRST_ROOM + options.seed + number
                view, target = scene(posture, seed)
                asked, drawn = (take(view, target, action, seed, name) for name in (posture, ""))
                if asked is None or drawn is None or asked.remarks:
                    continue
                found[posture].append((bool(rests(asked, action)[at]), bool(rests(drawn, action)[at])))
            pairs = np.array(found[posture]).reshape(-1, 2)
            print(
                f"{posture}: asked for, {pairs[:, 0].sum()} of {len(pairs)}; not asked for, {pairs[:, 1].sum()}",
                flush=True,
            )


if __name__ == "__main__":
    main()
