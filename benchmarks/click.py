"""Waiting times: baking a take, and complete clicks of Sit Here and Improvise in the living room of the demo.

python -m samp_blender.benchmarks.click
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ..samp_addon import rotation
from ..samp_addon.blender.actions import keyframes
from ..samp_addon.blender.character import character
from ..samp_addon.blender.takes import baking
from ..samp_addon.errors import SampError
from ..samp_addon.motion import Motion
from ..samp_addon.pipeline.job import Job

FRAMES = 600
CLICKS = 4
MANY = 32  # takes of one click
Seconds = tuple[float, float]
"""Seconds by the clock, and of the processor; other programs lengthen the first more than the second."""

SIT = Job(action="sit", target="Sofa", start=(-0.2, -2.3, 0.0, 200.0), hold=2.5)
IMPROVISE = Job(action="", method="scene_gan", settings={"seconds": 10.0})


def bake_seconds(runs: int = 5) -> float:
    """Return the median seconds to write a take of 600 frames and 55 joints."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    owner = character.create_character(bpy.context)
    rng = np.random.default_rng(0)
    rotations = rotation.from_axis_angle(rng.normal(scale=0.3, size=(FRAMES, 55, 3)))
    take = Motion(np.tile([0.0, 0.95, 0.0], (FRAMES, 1)), rotations)
    return float(np.median([_timed(lambda: keyframes.write_motion(owner, take))[0] for _ in range(runs)]))


def click_seconds() -> tuple[list[tuple[Seconds, dict]], Seconds, list[dict]]:
    """Time clicks of Sit Here.

    Return the seconds and the report entry of each click, the first of which includes all loading, and the seconds and
    the report entries of one click for MANY takes.
    """
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "demo"))
    import build_room

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    build_room.build(bpy.context.scene)
    character.create_character(bpy.context, location=SIT.start[:3])
    clicks = []
    for seed in range(CLICKS):
        results = []
        took = _timed(lambda s=seed, r=results: r.append(baking.run(bpy.context, replace(SIT, seed=s))))
        clicks.append((took, results[0].variants[0]))
    many = []
    took = _timed(lambda: many.append(baking.run(bpy.context, replace(SIT, variants=MANY))))
    return clicks, took, many[0].variants


def press_seconds() -> list[Seconds]:
    """Time presses of Improvise with the camera's picture; the first includes all loading."""
    return [
        _timed(lambda s=seed: baking.run(bpy.context, replace(IMPROVISE, seed=s))) for seed in range(CLICKS)
    ]


def _timed(work: Callable[[], object]) -> Seconds:
    begun = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - begun[0], time.process_time() - begun[1]


def _parts(variant: dict) -> str:
    return ", ".join(f"{name} {seconds:.2f}" for name, seconds in variant["seconds"].items())


def main() -> None:
    """Print one line per measurement."""
    print(f"bake of {FRAMES} frames, 55 bones: {1000 * bake_seconds():.0f} ms")
    try:
        clicks, took_many, many = click_seconds()
    except SampError as error:
        print(f"whole click: {error}")
        return
    for count, (took, variant) in enumerate(clicks):
        length = (variant["frame_end"] - variant["frame_start"]) / variant["fps"]
        which = "first click" if count == 0 else "click"
        text = f"{which}: {took[0]:.1f} s (processor {took[1]:.1f} s) for a take of {length:.1f} s"
        print(f"{text}, {variant['attempts']} attempts ({_parts(variant)})")
    one = np.median([took for took, _ in clicks[1:]], axis=0)
    tries = sum(variant["attempts"] for variant in many)
    text = f"{took_many[0]:.1f} s (processor {took_many[1]:.1f} s)"
    summary = f"{text}, {took_many[0] / one[0]:.1f} times one ({took_many[1] / one[1]:.1f}), {tries} attempts"
    print(f"{MANY} takes at once: {summary} ({_parts(many[0])}, the rest is writing and measuring)")
    pressed = ", ".join(f"{clock:.1f} s (processor {own:.1f} s)" for clock, own in press_seconds())
    print(f"Improvise, takes of {IMPROVISE.settings['seconds']:.0f} s: {pressed}")


if __name__ == "__main__":
    main()
