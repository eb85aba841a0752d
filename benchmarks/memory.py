"""Peak memory and depth of a refined sit on a bench alone, on a ground of 2 km, under a sky, and in a city.

python -m samp_blender.benchmarks.memory

Each scene is baked in a separate process. The exit status is 1 where one needs 2 GB or more.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

from ..samp_addon.scene.geometry import area_vectors
from ..tests.support.layouts import box

LIMIT = 2.0
"""Gigabytes."""

BAKE = Path(__file__).resolve().parent.parent / "bake.py"
BENCH = [
    ((-0.7, 0.41, -1.2), (0.7, 0.45, -0.8)),
    ((-0.7, 0.45, -1.22), (0.7, 0.85, -1.18)),
    ((-0.6, 0.0, -1.2), (-0.54, 0.41, -0.8)),
    ((0.54, 0.0, -1.2), (0.6, 0.41, -0.8)),
]
SCENES = ("small", "ground", "sky", "city")


def add(name: str, triangles: np.ndarray) -> None:
    """Add a mesh of triangles (F, 3, 3), network frame, to the scene."""
    assert (np.linalg.norm(area_vectors(triangles), axis=-1) > 0).all()
    points = np.stack([triangles[..., 0], -triangles[..., 2], triangles[..., 1]], -1).reshape(-1, 3)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))


def plane(half: float) -> np.ndarray:
    """Return the triangles (2, 3, 3) of a square ground. half: half its side, metres."""
    a, b, c, d = ((x, 0.0, z) for x, z in ((-half, -half), (-half, half), (half, half), (half, -half)))
    return np.array([(a, b, c), (a, c, d)])


def build(which: str, path: Path) -> None:
    """Build one of SCENES and save it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    add("Bench", np.concatenate([box(*corners) for corners in BENCH]))
    add("Ground", plane({"small": 4.0, "ground": 1000.0}.get(which, 250.0)))
    if which == "sky":
        bpy.ops.mesh.primitive_uv_sphere_add(radius=300)
    if which == "city":
        places = [(x, z) for x in range(-240, 240, 40) for z in range(-240, 240, 40) if abs(x) + abs(z) > 60]
        houses = [box((x, 0.0, z), (x + 20.0, 40.0 + (x * 7 + z * 3) % 160, z + 20.0)) for x, z in places]
        add("City", np.concatenate(houses))
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def bake(path: Path, report: Path) -> dict:
    """Bake a refined sit in a separate process; return its measures and the peak memory of all such processes, GB."""
    command = [sys.executable, str(BAKE), "--scene", str(path), "--action", "sit", "--target", "Bench"]
    command += ["--seed", "1", "--start", "0", "-2", "0", "180", "--hold", "0.5", "--refine"]
    subprocess.run([*command, "--report", str(report)], check=True, capture_output=True)
    made = json.loads(report.read_text())["variants"][0]
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6
    return {
        "deepest before, cm": made["refined"]["before"]["penetration_max_cm"],
        "deepest, cm": made["metrics"]["penetration_max_cm"],
        "contact": made["metrics"]["contact"],
        "peak GB": peak,
    }


def main() -> int:
    """Print a line for each scene, or for those named in the arguments; the peak includes all previous scenes."""
    chosen, worst = sys.argv[1:] or SCENES, 0.0
    with tempfile.TemporaryDirectory() as folder:
        for which in chosen:
            path = Path(folder) / f"{which}.blend"
            build(which, path)
            found = bake(path, Path(folder) / "report.json")
            worst = max(worst, found["peak GB"])
            print(which, ", ".join(f"{name} {value:.2f}" for name, value in found.items()), flush=True)
    return int(worst >= LIMIT)


if __name__ == "__main__":
    sys.exit(main())
