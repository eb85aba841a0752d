"""The same lines, with the real networks, by one process and by two parts: the same takes bit for bit."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import numpy as np
from batch_runs import ROOT, load


def bake(folder, *options, **environment):
    command = [sys.executable, str(ROOT / "bake.py"), "--jobs", "night.jsonl", *options]
    done = subprocess.run(
        command,
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, ""), done


def test_parts_make_the_takes_of_one_run(room, tmp_path):
    """The second line of the one run finds what the first one has cached; threads of torch differ."""
    scene, start = room
    shutil.copy(scene, tmp_path / "room.blend")
    shared = {"scene": "room.blend", "start": [float(v) for v in start], "hold": 0.5}
    jobs = [{"action": "walk", "target": "Sofa", "seed": 1}, {"action": "sit", "target": "Sofa", "seed": 2}]
    (tmp_path / "night.jsonl").write_text("".join(json.dumps(shared | job) + "\n" for job in jobs))
    bake(tmp_path, "--npz", "one", "--report", "one.json", OMP_NUM_THREADS="2")
    for part in ("1/2", "2/2"):
        bake(tmp_path, "--part", part, "--npz", "parts", "--report", f"{part[0]}.json", OMP_NUM_THREADS="1")
    names = sorted(os.listdir(tmp_path / "one"))
    assert names == sorted(os.listdir(tmp_path / "parts")) == ["room_sit_Sofa_2.npz", "room_walk_Sofa_1.npz"]
    for name in names:
        with np.load(tmp_path / "one" / name) as one, np.load(tmp_path / "parts" / name) as other:
            assert set(one.files) == set(other.files)
            assert all(one[key].tobytes() == other[key].tobytes() for key in one.files), name
    (build,) = load(tmp_path / "one.json")["builds"]
    assert set(build["weights"]) >= {"goal_net", "motion_net"} and all(
        len(checksum) == 64 for checksum in build["weights"].values()
    )
    assert {"program", "blender", "torch", "numpy"} <= set(build)
    assert load(tmp_path / "1.json")["builds"] == load(tmp_path / "2.json")["builds"] == [build]
    assert load(tmp_path / "2.json")["variants"][0]["job"]["seed"] == 2
