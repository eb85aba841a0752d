"""Milliseconds of scene preprocessing: voxels, navmesh, path.

python -m samp_blender.benchmarks.scene

Medians of several runs, as wall-clock and as processor time; the latter is more reliable on a busy machine.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np

from ..samp_addon.scene.navmesh import navmesh, path
from ..samp_addon.scene.voxels import InteractionGrid
from ..tests.support import layouts

RUNS = 9


def timed(work: Callable[[], object], runs: int = RUNS) -> tuple[float, float]:
    """Return the median wall-clock and processor milliseconds of a call, after one warm-up call."""
    work()
    wall, processor = [], []
    for _ in range(runs):
        begun = time.perf_counter(), time.process_time()
        work()
        wall.append(time.perf_counter() - begun[0])
        processor.append(time.process_time() - begun[1])
    return 1000 * statistics.median(wall), 1000 * statistics.median(processor)


def measure(runs: int = RUNS) -> dict[str, tuple[float, float]]:
    """Return (wall-clock, processor) milliseconds by the name of the measurement."""
    piece = layouts.ball(100_000, (0.9, 0.5, 0.6), (0, 0.5, 0))
    grid = InteractionGrid.build(piece)
    positions, yaws = np.zeros((32, 3)), np.zeros(32)
    room = layouts.furnished(seed=1)
    mesh = navmesh.build(room)
    start, goal = _far_apart(mesh)
    return {
        f"voxels of {len(piece)} triangles": timed(lambda: InteractionGrid.build(piece), runs),
        "grid features of 32 characters": timed(lambda: grid.features(positions, yaws), runs),
        f"navmesh of an 8 x 8 m room, {len(room)} triangles, 5 cm": timed(lambda: navmesh.build(room), runs),
        "path across it": timed(lambda: path.plan(mesh, start, goal), runs),
        "navmesh and path together": timed(lambda: path.plan(navmesh.build(room), start, goal), runs),
    }


def _far_apart(mesh: navmesh.NavMesh) -> tuple[np.ndarray, np.ndarray]:
    """Return two connected places on the floor at opposite corners of the room."""
    low = mesh.points[:, 1] < 0.1
    island = mesh.island_of(mesh.walkable)
    floor = mesh.points[low & (island == np.bincount(island[low]).argmax())]
    along = floor[:, 0] + floor[:, 2]
    return floor[along.argmin()], floor[along.argmax()]


def main() -> None:
    """Print one line per measurement."""
    for name, (wall, processor) in measure().items():
        print(f"{name:62s} {wall:8.1f} ms   (processor {processor:.1f} ms)")


if __name__ == "__main__":
    main()
