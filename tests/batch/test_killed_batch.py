"""A batch that is killed, at any time, and started again: nothing half-written, nothing done twice that was done."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.batch.resuming.saved_takes import SavedTakes
from samp_blender.samp_addon.blender.takes import baking
from samp_blender.samp_addon.methods.take import Failure, SubGoal, Take
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.refine.refinement import Refined

ROOT = Path(__file__).resolve().parents[2]
FAKES = ROOT / "tests" / "support" / "bake_with_fakes.py"


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Text of a jobs file: two jobs, each with two refined takes, as .blend and .npz."""
    scene = tmp_path_factory.mktemp("room") / "room.blend"
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    start = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(scene), copy=True)
    shared = {"scene": str(scene), "action": "sit", "target": "Sofa", "start": [float(v) for v in start]}
    jobs = [{"output": f"{seed}.blend", "npz": "npz", "seed": seed} for seed in (0, 10)]
    return "\n".join(json.dumps(shared | job | {"variants": 2, "refine": True}) for job in jobs) + "\n"


def begin(folder):
    command = [sys.executable, str(FAKES), "--jobs", "night.jsonl", "--report", "r.json"]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def whole(path):
    """Whether a file opens."""
    if path.suffix == ".npz":
        with np.load(path) as data:
            return all(data[name].size for name in data.files)
    if path.suffix == ".blend":
        with bpy.data.libraries.load(str(path)) as (inside, _):
            return len(inside.actions) == 2
    return all(json.loads(line) for line in path.read_text().splitlines()) if path.suffix else True


def results(folder):
    """What a killed run shows to the artist: no hidden files."""
    return [path for path in folder.rglob("*") if path.is_file() and not path.name.startswith(".")]


@pytest.mark.parametrize("moment", ["take 1/2: seed 0", "take 2/2: seed 1,", "1/2 done", "take 1/2: seed 10"])
def test_killed_after_a_line_and_started_again(night, tmp_path, moment):
    (tmp_path / "night.jsonl").write_text(night)
    process = begin(tmp_path)
    seen = []
    for line in process.stdout:
        seen.append(line)
        if moment in line:
            break
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    assert process.returncode == -signal.SIGKILL and moment in seen[-1]
    for path in results(tmp_path):
        assert path.name in ("r.json", "night.jsonl.done") or whole(path), path
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.blend")}
    if moment.startswith("take"):
        assert list((tmp_path / "night.jsonl.takes").glob("*.npz"))  # the reported takes are not lost

    process = begin(tmp_path)
    said, complained = process.communicate(timeout=200)
    assert (process.returncode, complained) == (0, "")
    # A job can be done although the kill came before its line.
    done = sum(line.endswith(" done\n") for line in seen)
    assert sum("done before" in line for line in said.splitlines()) in (done, len(before))
    report = json.loads((tmp_path / "r.json").read_text())
    assert [variant["seed"] for variant in report["variants"]] == [0, 1, 10, 11]
    assert all("refined" in variant for variant in report["variants"])
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"0.blend", "10.blend", "night.jsonl", "night.jsonl.done", "npz", "r.json"}
    assert len(list((tmp_path / "npz").iterdir())) == 4
    assert all(whole(path) for path in results(tmp_path) if path.suffix in (".npz", ".blend"))


@pytest.mark.parametrize("seconds", [0.0, 0.06, 0.2])
def test_killed_while_it_writes(night, tmp_path, seconds):
    """At odd moments after the first take: while the .blend, an .npz, the ledger or the report is being written."""
    (tmp_path / "night.jsonl").write_text(night.splitlines()[0])
    process = begin(tmp_path)
    for line in process.stdout:
        if "take 2/2" in line:
            break
    time.sleep(seconds)
    process.kill()
    process.communicate(timeout=60)
    for path in results(tmp_path):
        if path.suffix in (".npz", ".blend"):
            assert whole(path), path
        if path.name == "r.json":
            json.loads(path.read_text())
    process = begin(tmp_path)
    assert process.communicate(timeout=200)[1] == "" and process.returncode == 0
    assert list(tmp_path.rglob(".*")) == [] and whole(tmp_path / "0.blend")


def test_takes_that_are_kept_are_not_made_again(tmp_path):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    start = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    made = []

    def generate(requests, progress=lambda share: None):
        made.append(f"{len(requests)} rolled out")
        return fakes.generate(requests, progress)

    def refine(*arguments):
        if len(made) == 2:
            raise KeyboardInterrupt
        made.append("refined")
        return fakes.refine(*arguments)

    tools = fakes.toolbox(generate, refine=refine)
    job, kept = Job("sit", "Sofa", start=tuple(start), variants=3, refine=True), SavedTakes(tmp_path, "job")
    with pytest.raises(KeyboardInterrupt):
        baking.run(bpy.context, job, tools=tools, store=kept)
    assert made == ["3 rolled out", "refined"]
    made.append("stopped")
    seeds = []
    result = baking.run(
        bpy.context, job, tools=tools, store=kept, on_take=lambda take: seeds.append(take.seed)
    )
    assert made[3:] == ["refined", "refined"]
    assert seeds == [0, 1, 2]
    assert [variant["seed"] for variant in result.variants] == [0, 1, 2]


@pytest.fixture
def takes():
    still = np.zeros((4, 22, 4))
    still[..., 0] = 1
    motion = Motion(np.arange(12.0).reshape(4, 3), still, interaction_start=2, contacts=np.ones((4, 5)))
    goal = Goal(np.ones(3), np.array([0, 0, 1.0]), "sit")
    refined = Refined(
        motion, {"contact": np.float64(0.5), "success": True}, {"execution_time_s": None}, 0.02, ("A.",)
    )
    plain = Take(
        3, motion, "samp", {"rollout": 0.5}, 2, goal, np.zeros((2, 3)),
        sub_goals=(SubGoal(np.ones(3), np.ones(3), 7),), laid_ground=0.25,
    )  # fmt: skip
    return [plain, replace(plain, seed=4, steps=(plain,), refined=refined)]


def test_kept_takes_are_what_they_were(takes, tmp_path):
    kept = SavedTakes(tmp_path / "x.takes", "job")
    assert kept.load("3-2") is None
    kept.save("3-2", takes, [Failure(5, "It failed.")])
    (first, second), failures = kept.load("3-2")
    assert failures == [Failure(5, "It failed.")]
    assert (first.seed, first.seconds, first.attempts, first.laid_ground) == (3, {"rollout": 0.5}, 2, 0.25)
    np.testing.assert_array_equal(first.motion.root, takes[0].motion.root)
    assert first.sub_goals[0].frame == 7 and first.camera is None
    assert first.motion.interaction_start == 2 and first.motion.actions is None
    assert second.refined.before == {"contact": 0.5, "success": True} and second.refined.notes == ("A.",)
    assert second.steps[0].goal.action == "sit" and isinstance(second.steps, tuple)
    kept.forget()
    assert not kept.folder.exists()


@pytest.mark.parametrize("content", [b"", b"no zip", None])
def test_a_kept_file_that_is_no_good_counts_as_none(takes, tmp_path, content):
    kept = SavedTakes(tmp_path, "job")
    kept.save("3-2", takes, [])
    path = next(tmp_path.glob("*.npz"))
    path.write_bytes(path.read_bytes()[:-900] if content is None else content)
    assert kept.load("3-2") is None
