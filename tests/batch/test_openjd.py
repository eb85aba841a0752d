"""The template of Open Job Description, run by the format's own command line on a small jobs file."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from batch_runs import FAKES, ROOT, load

TEMPLATE = ROOT / "farm" / "openjd" / "template.yaml"
OPENJD = shutil.which("openjd", path=str(Path(sys.executable).parent)) or shutil.which("openjd")
pytestmark = pytest.mark.skipif(OPENJD is None, reason="openjd-cli is not installed")


@pytest.fixture
def night(room, tmp_path):
    """A jobs file of three lines with relative names, and a run of the template over it."""
    scene, start = room
    shutil.copy(scene, tmp_path / "room.blend")
    shared = {"scene": "room.blend", "action": "sit", "target": "Sofa", "start": [float(v) for v in start]}
    write_jobs(tmp_path, *(shared | {"seed": seed, "hold": 0.5} for seed in (1, 2, 3)))

    def begin(step="Merge", **parameters):
        values = {
            "JobsFile": tmp_path / "night.jsonl", "Lines": 3, "OutputFolder": tmp_path / "out", "ChunkSize": 2,
            "Blender": sys.executable, "BakeScript": FAKES,
        } | parameters  # fmt: skip
        command = [OPENJD, "run", str(TEMPLATE), "--step", step, "--run-dependencies"]
        command += [text for name, value in values.items() for text in ("-p", f"{name}={value}")]
        return subprocess.Popen(
            command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    return tmp_path, begin


def write_jobs(folder, *lines):
    (folder / "night.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))


def jobs(folder):
    return [json.loads(line) for line in (folder / "night.jsonl").read_text().splitlines()]


def finished(process):
    said, _ = process.communicate(timeout=300)
    return process.returncode, said


def test_chunks_are_baked_and_merged(night):
    folder, begin = night
    status, said = finished(begin())
    assert status == 0, said
    assert sorted(path.name for path in (folder / "out" / "parts").iterdir()) == ["1-2.json", "3-3.json"]
    assert [(row["line"], row["seed"]) for row in load(folder / "out" / "report.json")["variants"]] == [
        (1, 1), (2, 2), (3, 3),
    ]  # fmt: skip
    assert sorted(path.name for path in (folder / "out" / "npz").iterdir()) == [
        f"room_sit_Sofa_{seed}.npz" for seed in (1, 2, 3)
    ]
    assert (folder / "out" / "index.html").is_file() and (folder / "out" / "takes.csv").is_file()
    assert "openjd_progress: 50.0" in said and "openjd_status: 2/2 line 2" in said


def test_a_failing_line_fails_its_task_if_asked(night):
    folder, begin = night
    good = jobs(folder)
    write_jobs(folder, good[0], good[1] | {"target": "Nothing"}, good[2])
    status, said = finished(begin(OnFailure="fail"))
    assert status != 0 and "openjd_fail: Line 2: " in said
    assert not (folder / "out" / "report.json").exists()  # the merge waits for its dependency

    status, said = finished(begin())
    assert status == 0, said
    assert [row["line"] for row in load(folder / "out" / "report.json")["errors"]] == [2]
    assert "1/2 done before" in said


def test_a_task_that_cannot_begin_fails(night):
    _, begin = night
    status, said = finished(begin(JobsFile="nowhere.jsonl"))
    assert status != 0 and "openjd_fail: " in said and "nowhere.jsonl" in said


def test_a_cancelled_task_stops_and_the_next_run_goes_on(night):
    folder, begin = night
    process = begin(step="Bake", ChunkSize=3)
    seen = []
    for line in process.stdout:
        seen.append(line)
        if "bake: 1/3 done" in line:
            break
    process.send_signal(signal.SIGINT)
    said = "".join(seen) + process.communicate(timeout=300)[0]
    assert process.returncode != 0
    assert "openjd_fail: Stopped." in said and "3/3" not in said, said
    assert len(list((folder / "out" / "npz").glob("[!.]*.npz"))) in (1, 2)

    status, said = finished(begin(ChunkSize=3))
    assert status == 0, said
    assert "1/3 done before" in said
    assert len(load(folder / "out" / "report.json")["variants"]) == 3
    assert list(folder.rglob(".*")) == []
