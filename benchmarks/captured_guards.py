"""Guarded measures of captured sits, from which their limits were chosen.

python -m samp_blender.benchmarks.captured_guards --mocap FOLDER

FOLDER contains the sets of training clips. Since furniture is not captured, a block of 44 cm is placed under each sit,
with its top at the lowest skin of the buttocks during the hold. The exit status is 1 where more than one in fifteen
sits exceeds a limit.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..samp_addon import rotation
from ..samp_addon.body import human
from ..samp_addon.evaluation import guards, support
from ..samp_addon.evaluation.obstacles import Obstacles
from ..samp_addon.frames import yaw_direction
from ..samp_addon.motion import Goal, Motion
from ..tests.support.layouts import box
from ..training.mocap import clip_files
from ..training.mocap.clip_files import Clip
from ..training.mocap.events import SitEvent, sit_events

SETS = ("smplx30", "rocketbox30")
HALF = 0.22
"""Half the side of the block, metres."""

SHORTEST = 8
"""Frames of the shortest hold; sits with shorter ones are left out."""

LOOKED_AT = 24
"""Number of frames of the hold in which the lowest skin is measured."""

ALLOWED = 1 / 15


def block(event: SitEvent, height: float) -> np.ndarray:
    """Return the triangles (F, 3, 3) of a block under a sit. height: metres."""
    corners = box((-HALF, 0.0, -HALF), (HALF, height, HALF))
    return rotation.rotate(rotation.about_y(np.array(event.yaw)), corners) + event.pelvis * [1.0, 0.0, 1.0]


def sits(folder: Path) -> Iterator[tuple[Clip, SitEvent]]:
    """Yield the captured sits with a hold."""
    for name in SETS:
        for clip in clip_files.load_clips(folder / name):
            for event in sit_events(clip):
                if event.seat_end - event.seated + 1 >= SHORTEST:
                    yield clip, event


def measured(clip: Clip, event: SitEvent) -> dict[str, float | None]:
    """Return the measures of support of a sit, from its approach to the end of the hold."""
    part = clip.cut(event.entry, event.seat_end + 1)
    motion = Motion(part.root, part.rotations, 30.0)
    body, hold = human.load(), np.arange(event.seated - event.entry, len(motion))
    rows = hold[np.linspace(0, len(hold) - 1, min(LOOKED_AT, len(hold))).astype(int)]
    skin = human.skin(body, motion.pose_slice(rows), body.collision)[:, support.seat_skin(body)]
    height = float(np.median(skin[..., 1].min(1)))
    goal = Goal(event.pelvis, yaw_direction(event.yaw), "sit")
    return support.measures(motion, goal, Obstacles(block(event, height)), 0.0)


def main() -> int:
    """Print a line for each sit, and for each measure its distribution and limit."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mocap", type=Path, required=True)
    options = parser.parse_args()
    rows = []
    for clip, event in sits(options.mocap):
        rows.append(measured(clip, event))
        print(clip.name, {name: rows[-1][name] for name in guards.LIMITS}, flush=True)
    worst = 0.0
    for name, (limit, _) in guards.LIMITS.items():
        values = np.array([row[name] for row in rows if row[name] is not None], dtype=float)
        if not len(values):
            continue
        over = float((values > limit).mean())
        worst = max(worst, over)
        spread = ", ".join(f"{value:.2f}" for value in np.percentile(values, [50, 95, 99, 100]))
        print(f"{name}: {len(values)} sits, 50, 95, 99, 100 %: {spread}; limit {limit}, over it {over:.1%}")
    return int(worst > ALLOWED or not rows)


if __name__ == "__main__":
    sys.exit(main())
