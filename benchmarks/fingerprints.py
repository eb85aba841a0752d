"""Hashes of takes generated through the public entry points, to verify that a code change does not alter the motion.

python -m samp_blender.benchmarks.fingerprints --output before.json
python -m samp_blender.benchmarks.fingerprints --compare before.json

On one machine, the same seeds give bit for bit the same takes; on different machines, rounding differs.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
START = ["--start", "-0.2", "-2.3", "0", "200"]
BATCH = {
    "sit": ["--action", "sit", "--target", "Sofa", *START, "--seed", "1", "--variants", "3"],
    "sit_chair": ["--action", "sit", "--target", "Armchair", *START, "--seed", "5", "--style", "0.4"],
    "lie": ["--action", "lie", "--target", "Sofa", *START, "--seed", "2", "--hold", "1"],
    "walk": ["--action", "walk", "--to", "2.2", "-1.6", "0", "0", "--start", "-2.7", "-0.2", "0", "120"],
    "walk_free_start": ["--action", "walk", "--target", "Sofa", "--seed", "9", "--speed", "1.3"],
    "run": ["--action", "run", "--to", "2.2", "-1.6", "0", "--start", "-2.7", "-0.2", "0", "120"],
    "several_actions": [
        "--action",
        "walk,sit,lie",
        "--target",
        ",Armchair,Sofa",
        "--to",
        "1",
        "-2",
        "0",
        *START,
    ],
    "refined": ["--action", "sit", "--target", "Sofa", *START, "--seed", "3", "--hold", "1", "--refine"],
}
JOBS = [
    {"action": "sit", "target": "Sofa", "seed": 11, "start": [-0.2, -2.3, 0, 200]},
    {"action": "walk", "to": [1, -2, 0, 90], "seed": 4, "start": [-2.7, -0.2, 0, 120], "via": [0, -2.2, 0]},
]


def of_arrays(arrays: dict[str, np.ndarray]) -> str:
    """Hash named arrays, including names and shapes."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        digest.update(f"{name}{values.shape}{values.dtype}".encode() + values.tobytes())
    return digest.hexdigest()[:16]


def of_action(action: bpy.types.Action) -> str:
    """Hash the keyframes of an Action, per channel."""
    arrays = {}
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    for curve in (curve for bag in bags for curve in bag.fcurves):
        keys = np.empty(2 * len(curve.keyframe_points), np.float32)
        curve.keyframe_points.foreach_get("co", keys)
        arrays[f"{curve.data_path}[{curve.array_index}]"] = keys
    return of_arrays(arrays)


def batch_takes(room: Path, folder: Path) -> dict[str, str]:
    """Hash takes of the batch's command line and of a jobs file."""
    jobs = folder / "jobs.jsonl"
    jobs.write_text("".join(json.dumps(job | {"npz": str(folder / "jobs")}) + "\n" for job in JOBS))
    runs = {name: [*options, "--npz", str(folder / name)] for name, options in BATCH.items()}
    runs["jobs"] = ["--jobs", str(jobs)]
    found = {}
    for name, options in runs.items():
        command = [sys.executable, str(ROOT / "bake.py"), "--scene", str(room), *options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        for file in sorted((folder / name).glob("*.npz")):
            with np.load(file) as data:
                found[f"{name}/{file.stem}"] = of_arrays({key: data[key] for key in data.files})
    return found


def operator_takes(room: Path) -> dict[str, str]:
    """Hash takes of the operators: Sit Here, Refine, and Carry to Rig with a Mixamo rig."""
    import samp_blender

    sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "tests" / "support" / "blender")]
    import humanoids

    bpy.ops.wm.open_mainfile(filepath=str(room))
    samp_blender.register()
    try:
        bpy.ops.samp.create_character(location=(-0.2, -2.3, 0.0))
        person = bpy.context.object.name
        bpy.ops.samp.sit_here(target="Sofa", seed=2, hold=1.0, character=person)
        take = bpy.data.objects[person].animation_data.action
        found = {"operator/sit_here": of_action(take)}
        rig = humanoids.make("mixamo")
        bpy.ops.samp.carry_to_rig(target=rig.name, character=person)
        found["operator/carry_to_rig"] = of_action(rig.animation_data.action)
        bpy.data.objects.remove(rig)
        bpy.ops.samp.refine(character=person, action_name=take.name)
        found["operator/refine"] = of_action(bpy.data.objects[person].animation_data.action)
    finally:
        samp_blender.unregister()
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, help="JSON file of the hashes to write")
    parser.add_argument(
        "--compare", type=Path, help="JSON file of an earlier run; the status is 1 where a hash differs"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        room = folder / "room.blend"
        build = f"import bpy, runpy; runpy.run_path({str(ROOT / 'demo' / 'build_room.py')!r}, run_name='__main__')"
        subprocess.run([sys.executable, "-c", build, str(room)], check=True)
        found = batch_takes(room, folder) | operator_takes(room)
    if options.output:
        options.output.write_text(json.dumps(found, indent=1) + "\n")
    before = json.loads(options.compare.read_text()) if options.compare else {}
    different = [name for name in before if found.get(name) != before[name]]
    for name in sorted(found):
        print(name, found[name], "differs" if name in different else "")
    print(f"{len(found)} takes, {len(different)} of {len(before)} compared differ")
    return int(bool(different))


if __name__ == "__main__":
    sys.exit(main())
