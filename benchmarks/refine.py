"""Time and memory of refinement for different take lengths and numbers of vertices.

It is compared with a plain version of the same energies: every vertex in every frame, distances updated in every step,
no windows.

python -m samp_blender.benchmarks.refine

Each run is a separate process, to measure its memory.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from dataclasses import asdict, replace

import numpy as np

from ..samp_addon.body import human
from ..samp_addon.methods.scene_view import SceneView
from ..samp_addon.motion import Motion
from ..samp_addon.pipeline import driver
from ..samp_addon.pipeline.driver import Work
from ..samp_addon.pipeline.job import Job
from ..samp_addon.refine import optimiser, refinement
from ..samp_addon.refine.feet.plan import plan_feet
from ..samp_addon.refine.field import Field
from ..samp_addon.scene.geometry import SceneGeometry
from ..tests.support import rooms

LENGTHS = (10, 20, 40, 60)  # seconds
VERTICES = (512, 1024, 2048)
SHORT = 5  # seconds of motion for different numbers of vertices
PLAIN = 1  # seconds of motion for the plain version


def take() -> tuple[Motion, rooms.Room]:
    """Generate a take of sitting down in a room of boxes."""
    room = rooms.random_room(1, rooms.sofa)
    pieces = [("Floor", room.floor)] + [(piece.name, piece.triangles) for piece in room.pieces]
    view = SceneView(
        SceneGeometry.from_objects(pieces),
        room.target.triangles,
        (room.target.name,),
        (room.start, room.start_yaw),
    )
    takes, _ = driver.run(Work(Job(action="sit", target=room.target.name), [view]))
    return takes[0].motion, room


def long(motion: Motion, seconds: float) -> Motion:
    """Extend a motion to a length by repeating it forwards and backwards."""
    count = round(seconds * motion.fps) + 1
    both = np.concatenate([np.arange(len(motion)), np.arange(len(motion) - 2, 0, -1)])
    rows = np.resize(both, count)
    return Motion(motion.root[rows], motion.rotations[rows], motion.fps)


def run(kind: str, seconds: float, vertices: int) -> None:
    """Run once; print the seconds and the additional megabytes."""
    motion, room = take()
    motion, body = long(motion, seconds), human.load()
    body = replace(body, collision=body.collision[:: len(body.collision) // vertices])
    scene = refinement.Surroundings(room.triangles, np.zeros(len(room.triangles)), 0.0)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begun = time.perf_counter()
    if kind == "plain":
        _plain(motion, scene, replace(body, collision=np.arange(len(body.vertices))))
    else:
        refinement.refine(motion, scene, body=body, measured=False)
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(f"{time.perf_counter() - begun:.2f} {used / 1024:.0f}")


def _plain(motion: Motion, scene: refinement.Surroundings, body: human.Human) -> None:
    """Run both stages with every vertex, every frame, and distances updated in every step."""
    free = human.skin(body, motion, body.collision[::50]).reshape(-1, 3)[::50].astype(np.float64)
    field = Field(scene.triangles, scene.give, scene.floor, free)
    weights = {k: v for k, v in asdict(refinement.Settings()).items() if k in optimiser.SCALES}
    every = optimiser.Sampling(every=1, rate=1e9, near=np.inf)
    for stage in (0, 1):
        optimiser.Optimiser(
            motion, body, field, weights, plan_feet(motion, field), None, np.zeros(len(motion)), every
        ).solve(stage)


def main() -> None:
    """Print a table; with arguments, run once."""
    if len(sys.argv) > 1:
        run(sys.argv[1], float(sys.argv[2]), int(sys.argv[3]))
        return
    plans = [("ours", seconds, 2048) for seconds in LENGTHS]
    plans += (
        [("ours", SHORT, vertices) for vertices in VERTICES]
        + [("ours", PLAIN, 2048)]
        + [("plain", PLAIN, 2048)]
    )
    for kind, seconds, vertices in plans:
        done = subprocess.run(
            [sys.executable, "-m", __spec__.name, kind, str(seconds), str(vertices)],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        took, used = done.stdout.split()[-2:]
        rate = float(took) / seconds
        name = "every vertex" if kind == "plain" else f"{vertices} vertices"
        print(
            f"{kind}, {seconds} s of motion, {name}: {took} s ({rate:.2f} s per second), {used} MB",
            flush=True,
        )


if __name__ == "__main__":
    main()
