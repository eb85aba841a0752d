"""Rooms that nobody has seen: how often does the batch bring the character to its seat?

python -m samp_blender.benchmarks.judge [--rooms 10] [--seed 100] [--keep FOLDER]

Each room has a seat turned any way, five obstacles, and a start behind one of them (tests/rooms.py). Counted are
runs that exit with 0, paths that cross an obstacle, and sits whose pelvis ends within 20 cm and 20 degrees.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

from ..samp_addon import frames
from ..tests.support import rooms

ROOT = Path(__file__).resolve().parent.parent
DISTANCE_CM, ANGLE_DEG = 20.0, 20.0


def judge(seed: int, folder: Path) -> dict:
    """One room through bake.py: status, crossings, and the report's measures."""
    room = rooms.random_room(seed)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    start = rooms.to_blender(room, bpy.context.scene)
    scene, report = folder / f"room_{seed}.blend", folder / f"room_{seed}.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene), copy=True)
    options = ["--scene", scene, "--action", "sit", "--target", room.target.name, "--start", *start]
    options += ["--seed", seed, "--output", folder / f"take_{seed}.blend", "--report", report]
    command = [sys.executable, str(ROOT / "bake.py"), *map(str, options)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    told = {"seed": seed, "seat": room.target.name, "status": done.returncode, "says": done.stderr.strip()}
    if done.returncode == 0:
        variant = json.loads(report.read_text())["variants"][0]
        told["crossed"] = room.crossings(frames.to_network(np.array(variant["waypoints"])))
        told |= variant["metrics"]
        told["seconds"] = sum(variant["seconds"].values())
    return told


def reached(told: dict) -> bool:
    """Whether the pelvis ended within 20 cm and 20 degrees of its goal."""
    return (
        told["status"] == 0
        and told["position_error_cm"] <= DISTANCE_CM
        and told["rotation_error_deg"] <= ANGLE_DEG
    )


def main() -> int:
    """Prints a line for each room and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", type=int, default=10)
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--keep", type=Path, help="folder for rooms, takes and reports")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        told = []
        for seed in range(options.seed, options.seed + options.rooms):
            told.append(judge(seed, folder))
            print(line(told[-1]), flush=True)
    done = [one for one in told if one["status"] == 0]
    print(f"exit status 0: {len(done)} of {len(told)}")
    print(f"paths over an obstacle: {sum(bool(one['crossed']) for one in done)}")
    print(f"within 20 cm and 20 degrees: {sum(map(reached, told))} of {len(told)}")
    return 0


def line(told: dict) -> str:
    """One room's result."""
    if told["status"] != 0:
        return f"{told['seed']} {told['seat']}: status {told['status']}: {told['says']}"
    return (
        f"{told['seed']} {told['seat']}: {told['position_error_cm']:.1f} cm, "
        f"{told['rotation_error_deg']:.1f} deg, penetration {told['penetration_max_cm']:.1f} cm, "
        f"foot slide {told['foot_slide_cm_s']:.1f} cm/s, {told['seconds']:.1f} s"
        + (f", crosses {', '.join(told['crossed'])}" if told["crossed"] else "")
    )


if __name__ == "__main__":
    sys.exit(main())
