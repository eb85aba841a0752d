"""Place in a file of 5,000 objects: reading the scene, and from a place of the mouse to what lights up.

python -m samp_blender.benchmarks.place [--looks 200]

Times are wall-clock and those of this thread alone; on a busy machine the second says more. Uploading the body to the
graphics card and drawing it are not part of it: there is no window here.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from ..samp_addon.blender.character import character
from ..samp_addon.blender.placing import reading
from ..samp_addon.pipeline.placing import Spot
from ..samp_addon.scene.geometry import extent
from . import large

EYE = np.array([3.0, 3.2, 4.0])
"""Where the mouse looks from, network frame, metres."""


@dataclass(frozen=True)
class Took:
    """Seconds: wall-clock, and of this thread."""

    wall: float
    own: float


def timed(work: Callable[[], object]) -> tuple[object, Took]:
    """Return what the work returns, and what it took."""
    wall, own = time.perf_counter(), time.thread_time()
    made = work()
    return made, Took(time.perf_counter() - wall, time.thread_time() - own)


def main() -> None:
    """Print a line for each measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=int, default=200, help="places of the mouse")
    options = parser.parse_args()
    print(large.many_objects(), flush=True)
    owner = character.create_character(bpy.context, location=(2.0, -2.0, 0.0))
    bpy.context.view_layer.update()
    placer, took = timed(lambda: reading.read(bpy.context, owner))
    print(f"reading, once: {took.wall:.2f} s ({took.own:.2f} s)", flush=True)
    _, took = timed(placer.survey)
    print(f"walkable ground, in a thread: {took.wall:.2f} s ({took.own:.2f} s)", flush=True)
    rng, times, found = np.random.default_rng(0), [], []
    names = [name for name in placer.scene.names if not name.startswith(("Box", "Floor"))]
    low, high = extent(placer.scene.triangles_of(names))
    for count in range(options.looks):
        # By turns over the furniture in the room and anywhere among the boxes.
        aim = rng.uniform(low, high) if count % 2 else rng.uniform((-20, 0, -20), (20, 0, 20))
        spot, took = timed(lambda aim=aim: placer.under(EYE, aim - EYE))
        times.append(took)
        found.append(spot)
    report("from mouse move to highlight", times)
    print(_summary(found))


def report(what: str, times: list[Took]) -> None:
    """Print the median, the slowest twentieth and the slowest of some times, in milliseconds."""
    for name in ("wall", "own"):
        values = 1000 * np.array([getattr(took, name) for took in times])
        print(
            f"{what} ({name}): median {np.median(values):.1f} ms, 95 % {np.quantile(values, 0.95):.1f} ms, "
            f"slowest {values.max():.1f} ms",
            flush=True,
        )


def _summary(found: list[Spot | None]) -> str:
    fits: dict[str, int] = {}
    for spot in found:
        key = "nothing" if spot is None else f"{spot.action} on {'furniture' if spot.target else 'a floor'}"
        key += "" if spot is None or spot.fits else ", not possible"
        fits[key] = fits.get(key, 0) + 1
    return ", ".join(f"{count} {key}" for key, count in sorted(fits.items()))


if __name__ == "__main__":
    main()
