"""Success rate of the batch in random rooms.

python -m samp_blender.benchmarks.judge [--rooms 10] [--seed 100] [--keep FOLDER]

Each room has a seat at a random yaw, five obstacles, and a start behind one of them (tests/support/rooms.py). The
result is the number of runs with exit status 0, of paths that cross an obstacle, of takes that end within 20 cm and 20
degrees of the goal, and of takes with warnings. The exit status is 1 where a run fails, a path crosses an obstacle, or
less than 90 % of the takes reach their goal without a warning.
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
LEAST_REACHED = 0.9


def judge(seed: int, folder: Path) -> dict:
    """Run bake.py in one room; return its status, the crossed obstacles and the metrics of the report."""
    room = rooms.random_room(seed)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    start = rooms.to_blender(room, bpy.context.scene)
    scene, report = folder / f"room_{seed}.blend", folder / f"room_{seed}.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene), copy=True)
    options = ["--scene", scene, "--action", "sit", "--target", room.target.name, "--start", *start]
    options += ["--seed", seed, "--output", folder / f"take_{seed}.blend", "--report", report]
    command = [sys.executable, str(ROOT / "bake.py"), *map(str, options)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    result = {"seed": seed, "seat": room.target.name, "status": done.returncode, "says": done.stderr.strip()}
    if done.returncode == 0:
        variant = json.loads(report.read_text())["variants"][0]
        result["crossed"] = room.crossings(frames.to_network(np.array(variant["waypoints"])))
        result |= variant["metrics"]
        result["warnings"] = variant["warnings"]
        result["seconds"] = sum(variant["seconds"].values())
    return result


def reached(result: dict) -> bool:
    """Return whether the pelvis ended within 20 cm and 20 degrees of its goal."""
    return (
        result["status"] == 0
        and result["position_error_cm"] <= DISTANCE_CM
        and result["rotation_error_deg"] <= ANGLE_DEG
    )


def passes(results: list[dict]) -> bool:
    """Return whether all runs succeed, no path crosses an obstacle, and LEAST_REACHED of the takes are good."""
    if not results or any(one["status"] != 0 or one["crossed"] for one in results):
        return False
    good = sum(reached(one) and not one["warnings"] for one in results)
    return good >= LEAST_REACHED * len(results)


def main() -> int:
    """Print one line per room and the counts; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", type=int, default=10)
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--keep", type=Path, help="folder in which to keep rooms, takes and reports")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        results = []
        for seed in range(options.seed, options.seed + options.rooms):
            results.append(judge(seed, folder))
            print(line(results[-1]), flush=True)
    done = [one for one in results if one["status"] == 0]
    print(f"exit status 0: {len(done)} of {len(results)}")
    print(f"paths over an obstacle: {sum(bool(one['crossed']) for one in done)}")
    print(f"within 20 cm and 20 degrees: {sum(map(reached, results))} of {len(results)}")
    print(f"with warnings: {sum(bool(one['warnings']) for one in done)}")
    return 0 if passes(results) else 1


def line(result: dict) -> str:
    """Format the result of one room."""
    if result["status"] != 0:
        return f"{result['seed']} {result['seat']}: status {result['status']}: {result['says']}"
    return (
        f"{result['seed']} {result['seat']}: {result['position_error_cm']:.1f} cm, "
        f"{result['rotation_error_deg']:.1f} deg, penetration {result['penetration_max_cm']:.1f} cm, "
        f"foot slide {result['foot_slide_cm_s']:.1f} cm/s, {result['seconds']:.1f} s"
        + (f", crosses {', '.join(result['crossed'])}" if result["crossed"] else "")
        + "".join(f" {warning}" for warning in result["warnings"])
    )


if __name__ == "__main__":
    sys.exit(main())
