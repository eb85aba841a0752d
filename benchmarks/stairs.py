"""Benchmark of walks over stairs and ramps: soles in treads, toes in risers, a pelvis that turns back on its way.

python -m samp_blender.benchmarks.stairs --flights 20 --output stairs.json

Flights rise 12 to 22 cm a step, half of them are walked down, every third has a landing with a turn, every fourth is
of boards without risers. Then ramps of 10, 20 and 30 degrees, up and down. All takes are first attempts, not refined.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..samp_addon.body import human
from ..samp_addon.frames import direction_yaw
from ..samp_addon.methods.method import Draw
from ..samp_addon.methods.samp.method import Samp
from ..samp_addon.methods.scene_view import SceneView
from ..samp_addon.methods.step import Step
from ..samp_addon.motion import Motion
from ..samp_addon.refine.feet.foot import FEET, sole_points, toe_tips
from ..samp_addon.scene.distance import signed_distance
from ..samp_addon.scene.geometry import SceneGeometry
from .cast import box

BACK = 0.002
"""Metres in a frame by which the pelvis goes down on the way up, or up on the way down."""
WIDTH, FLOOR, ROOM = 1.2, 0.2, 4.0
RAMPS = (10, 20, 30)


@dataclass(frozen=True)
class Ground:
    """A scene to walk over: its triangles, and the ends of the walk, floor positions (3,), low and high."""

    name: str
    triangles: np.ndarray
    low: np.ndarray
    high: np.ndarray


def flight(number: int) -> Ground:
    """Return a random flight of stairs."""
    rng = np.random.default_rng(number)
    rise, going, count = rng.uniform(0.12, 0.22), rng.uniform(0.24, 0.34), int(rng.integers(4, 13))
    landing, boards = number % 3 == 2, number % 4 == 3
    parts = [box((-ROOM, -FLOOR, -ROOM), (ROOM, 0, 0 if boards else going / 2))]
    at, ahead = np.zeros(3), np.array([0.0, 0.0, 1.0])
    runs = [count // 2, count - count // 2] if landing else [count]
    for k, steps in enumerate(runs):
        last = k == len(runs) - 1
        treads = steps - 1 if last else steps  # the floor above is the last one
        across = np.array([ahead[2], 0.0, -ahead[0]])
        for n in range(treads):
            ends = np.array([at + (n + m) * going * ahead + (m - 0.5) * WIDTH * across for m in (0, 1)])
            low, high = ends.min(0), ends.max(0)
            high[1] = at[1] + (n + 1) * rise
            low[1] = high[1] - 0.04 if boards else 0.0
            parts.append(box(low, high))
        top = at + treads * going * ahead + [0, steps * rise, 0]
        if not last:
            parts.append(box(top + [-WIDTH / 2, -FLOOR, 0], top + [WIDTH / 2, 0, WIDTH]))
            at, ahead = top + [WIDTH / 2, 0, WIDTH / 2], np.array([1.0, 0.0, 0.0])
    wide = ROOM * np.array([abs(ahead[2]), 0, abs(ahead[0])])
    ends = np.array([top - wide - [0, FLOOR, 0], top + wide + ROOM * ahead])
    parts.append(box(ends.min(0), ends.max(0)))
    name = f"{count} steps of {100 * rise:.0f} cm on {100 * going:.0f}"
    name += (", landing" if landing else "") + (", boards" if boards else "")
    return Ground(name, np.concatenate(parts), np.array([rng.uniform(-0.3, 0.3), 0, -2.2]), top + 2.2 * ahead)


def ramp(degrees: float) -> Ground:
    """Return a ramp that rises by 1.2 m."""
    run, rise = 1.2 / np.tan(np.radians(degrees)), 1.2
    a, b = np.array([-WIDTH / 2, 0.0, 0.0]), np.array([WIDTH / 2, 0.0, 0.0])
    up = np.array([0.0, rise, run])
    slope = np.array([(a, b + up, b), (a, a + up, b + up)])
    floors = [
        box((-ROOM, -FLOOR, -ROOM), (ROOM, 0, 0)),
        box((-ROOM, rise - FLOOR, run), (ROOM, rise, run + ROOM)),
    ]
    ends = np.array([0.0, 0, -2.2]), np.array([0.0, rise, run + 2.2])
    return Ground(f"ramp of {degrees} degrees", np.concatenate([slope, *floors]), *ends)


def walked(ground: Ground, down: bool, seed: int) -> Motion | str:
    """Return a walk over the ground, or why there is none."""
    start, end = (ground.high, ground.low) if down else (ground.low, ground.high)
    geometry = SceneGeometry.from_objects([("Stairs", ground.triangles)])
    view = SceneView(geometry, start=(start, float(direction_yaw(end - start))), destination=(end, None))
    takes, failed = Samp().generate(
        Step(action="walk", to=tuple(end)), view, [Draw(seed, seed)], lambda *_: None
    )
    return takes[0].motion if takes else failed[0].message


def measures(motion: Motion, ground: Ground, down: bool) -> dict[str, float]:
    """Return centimetres and shares of frames, see main."""
    field = signed_distance.cached_field(
        ground.triangles, np.stack([ground.low, ground.high]) + [0.0, 1.0, 0.0]
    )
    depth = lambda points: -field.at(points.reshape(-1, 3).astype(float))[0].reshape(points.shape[:-1])
    positions, globals_ = motion.forward_kinematics()
    soles, tips = [], []
    for foot in FEET:
        soles += sole_points(positions, globals_, motion.rest_joints, foot.side)
        tips.append(toe_tips(positions, globals_, motion.rest_joints, foot.side))
    body = human.load()
    skin = depth(human.skin(body, motion, body.collision)).max(1)
    rises = np.diff(motion.root[:, 1]) * (-1 if down else 1)
    # The first and last metre belong to walking on a floor, where a pelvis goes up and down.
    climbing = (motion.root[:-1, 1] > ground.low[1] + 1.05) & (motion.root[:-1, 1] < ground.high[1] + 0.85)
    end = ground.low if down else ground.high
    return {
        "off_goal_cm": 100 * float(np.linalg.norm((motion.root[-1] - end)[[0, 2]])),
        "sole_cm": 100 * float(np.max([depth(sole).max() for sole in soles])),
        "toe_frames": float(np.mean([(depth(tip) > 0.01).mean() for tip in tips])),
        "skin_cm": 100 * float(skin.max()),
        "skin_2cm_percent": 100 * float((skin > 0.02).mean()),
        "turns_back_percent": 100 * float((rises[climbing] < -BACK).mean()) if climbing.any() else 0.0,
    }


def main() -> None:
    """Print a line for each ground, then how many arrive and the worst of each measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--flights", type=int, default=20)
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    grounds = [(flight(k), k % 2 == 1) for k in range(options.flights)]
    grounds += [(ramp(degrees), down) for degrees in RAMPS for down in (False, True)]
    found = {}
    for seed, (ground, down) in enumerate(grounds):
        name = f"{ground.name}, {'down' if down else 'up'}"
        motion = walked(ground, down, seed)
        found[f"{seed} {name}"] = motion if isinstance(motion, str) else measures(motion, ground, down)
        values = found[f"{seed} {name}"]
        text = values if isinstance(values, str) else " ".join(f"{k} {v:.2f}" for k, v in values.items())
        print(f"{name}: {text}", flush=True)
    kinds = {
        "stairs": list(found.values())[: options.flights],
        "ramps": list(found.values())[options.flights :],
    }
    for kind, rows in kinds.items():
        arrived = [row for row in rows if not isinstance(row, str)]
        worst = {key: max(row[key] for row in arrived) for key in arrived[0]} if arrived else {}
        print(
            f"{kind}: {len(arrived)} of {len(rows)} arrive; worst:",
            {k: round(v, 2) for k, v in worst.items()},
        )
    if options.output:
        options.output.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
