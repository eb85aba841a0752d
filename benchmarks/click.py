"""Waiting times: baking a take, and a complete click of Sit Here in the living room of the demo.

python -m samp_blender.benchmarks.click
"""

from __future__ import annotations

import sys
import time
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
SIT = Job(action="sit", target="Sofa", start=(-0.2, -2.3, 0.0, 200.0), hold=2.5)


def bake_seconds(runs: int = 5) -> float:
    """Return the median seconds to write a take of 600 frames and 55 joints."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    owner = character.create_character(bpy.context)
    rng = np.random.default_rng(0)
    rotations = rotation.from_axis_angle(rng.normal(scale=0.3, size=(FRAMES, 55, 3)))
    take = Motion(np.tile([0.0, 0.95, 0.0], (FRAMES, 1)), rotations)
    return float(np.median([_timed(lambda: keyframes.write_motion(owner, take)) for _ in range(runs)]))


def click_seconds() -> tuple[list[tuple[float, dict]], float, list[dict]]:
    """Time clicks of Sit Here.

    Return the wall-clock seconds and the report entry of each click, the first of which includes all loading, and the
    seconds and the report entries of one click for MANY takes.
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


def _timed(work: object) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


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
        print(f"{which}: {took:.1f} s for a take of {length:.1f} s ({_parts(variant)})")
    one = float(np.median([took for took, _ in clicks[1:]]))
    tries = sum(variant["attempts"] for variant in many)
    summary = f"{took_many:.1f} s, {took_many / one:.1f} times one, {tries} attempts"
    print(f"{MANY} takes at once: {summary} ({_parts(many[0])}, the rest is writing and measuring)")


if __name__ == "__main__":
    main()
