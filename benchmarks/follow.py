"""From a dragged goal, way-point or target to the new take, and Redo From Here, in the living room of the demo.

python -m samp_blender.benchmarks.follow [--runs 5]

Times are those of the clock and of the process; other programs lengthen the first more than the second. A first edit,
which loads the networks, is not counted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ..samp_addon.blender import compat
from ..samp_addon.blender.actions import notes
from ..samp_addon.blender.character import character
from ..samp_addon.blender.edits import following, redo
from ..samp_addon.blender.edits.redo import Redone
from ..samp_addon.blender.overlays import goal_arrows, waypoints
from ..samp_addon.blender.takes import baking
from ..samp_addon.errors import SampError
from .click import SIT

WANTED = 2.0
"""Seconds from the end of a drag to the new take."""
VIA = (-0.9, -1.0, 0.0)
"""A way-point on the way to the sofa, metres."""
DRAGGED = 0.2
"""Metres by which an object is dragged along X."""

Bake = tuple[bpy.types.Object, bpy.types.Action]
"""A character and its take."""


@dataclass(frozen=True)
class Took:
    """One edit. wall, process: seconds. frame, last: the last frame that stays, and that of the new take. same: whether
    the keys up to there are equal bit for bit."""

    wall: float
    process: float
    frame: int
    last: int
    same: bool


def baked(seed: int) -> Bake:
    """Bake a sit on the sofa, on a goal and past a way-point that can be dragged; return its character and Action."""
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "demo"))
    import build_room

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    build_room.build(bpy.context.scene)
    owner = character.create_character(bpy.context, location=SIT.start[:3])
    goal_arrows.sample_goals(bpy.context, SIT.target, count=1, seed=seed)
    waypoints.add(bpy.context, VIA)
    return owner, baking.run(bpy.context, replace(SIT, seed=seed)).actions[0]


def edit(made: Bake, work: Callable[[], Redone]) -> Took:
    """Time an edit of a take, and compare the frames that stay."""
    owner, take = made
    wall, process = time.perf_counter(), time.process_time()
    new = work()
    wall, process = time.perf_counter() - wall, time.process_time() - process
    before, after = (keys(owner, action, new.frame) for action in (take, new.action))
    last = notes.take_end(new.action)
    return Took(wall, process, new.frame, last, all(after[path] == rows for path, rows in before.items()))


def keys(owner: bpy.types.Object, action: bpy.types.Action, last: int) -> dict:
    """Return the times and values of all keys of an Action up to a frame."""
    return {
        (curve.data_path, curve.array_index): [tuple(k.co) for k in curve.keyframe_points if k.co.x <= last]
        for curve in compat.curves(action, owner)
    }


def follow(name: str, seed: int) -> Took:
    """Drag an object by DRAGGED along the sofa and time Follow."""
    owner, take = made = baked(seed)
    bpy.data.objects[name].location.x += DRAGGED if seed % 2 else -DRAGGED
    return edit(made, lambda: following.run(bpy.context, owner, take))


def redo_from(share: float, seed: int) -> Took:
    """Time Redo From Here after a share of the take."""
    owner, take = made = baked(seed)
    first, last = round(take.frame_range[0]), notes.take_end(take)
    frame = first + round(share * (last - first))
    return edit(made, lambda: redo.run(bpy.context, owner, take, frame))


def main() -> None:
    """Print a line for each kind of edit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5, help="takes that are edited in each way")
    options = parser.parse_args()
    arrow = f"Goal sit {SIT.target}"
    edits: dict[str, Callable[[int], Took]] = {
        "a dragged goal": lambda seed: follow(arrow, seed),
        "a dragged way-point": lambda seed: follow("Way-point 1", seed),
        "a dragged target": lambda seed: follow(SIT.target, seed),
        "Redo From Here in the middle": lambda seed: redo_from(0.5, seed),
    }
    follow("Way-point 1", 0)
    for what, work in edits.items():
        took = []
        for seed in range(options.runs):
            try:
                took.append(work(seed))
            except SampError as error:
                print(f"{what}, seed {seed}: {error}", flush=True)
        report(what, took)


def report(what: str, took: list[Took]) -> None:
    """Print the times of a kind of edit, and in how many takes the frames before the change are equal."""
    if not took:
        return
    wall, process = (np.array([getattr(one, name) for one in took]) for name in ("wall", "process"))
    new = np.median([one.last - one.frame for one in took])
    print(
        f"{what}: {np.median(wall):.2f} s, at most {wall.max():.2f} s by the clock; {np.median(process):.2f} s, at "
        f"most {process.max():.2f} s of the process (wanted {WANTED:.0f}); {new:.0f} new frames of "
        f"{np.median([one.last for one in took]):.0f}; frames before equal in {sum(one.same for one in took)} of "
        f"{len(took)}",
        flush=True,
    )


if __name__ == "__main__":
    main()
