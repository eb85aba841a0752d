"""Flamenco's job type, compiled as its manager does, and the commands that come of it, run on a small jobs file."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys

import pytest
from batch_runs import FAKES, ROOT, load

quickjs = pytest.importorskip("quickjs", reason="quickjs is not installed")
SCRIPT = (ROOT / "farm" / "flamenco" / "samp_bake.js").read_text(encoding="utf-8")

# The functions that a manager gives to scripts, and a job that collects its tasks.
HOST = """
const author = {
    Task: (name, type) => ({
        name: name, type: type, commands: [], dependencies: [],
        addCommand: function (command) { this.commands.push(command); },
        addDependency: function (task) { this.dependencies.push(task.name); },
    }),
    Command: (name, parameters) => ({ name: name, parameters: parameters }),
};
const path = { join: (...parts) => parts.join("/") };
const job = { settings: JSON.parse(settings), tasks: [], addTask: function (task) { this.tasks.push(task); } };
"""


def compiled(**settings):
    """Return the tasks of a job."""
    context = quickjs.Context()
    context.set("settings", json.dumps(settings))
    context.eval(HOST + SCRIPT)
    context.eval("compileJob(job)")
    return json.loads(context.eval("JSON.stringify(job.tasks)"))


def job_type():
    context = quickjs.Context()
    context.eval(SCRIPT)
    return json.loads(context.eval("JSON.stringify(JOB_TYPE)"))


SETTINGS = {
    "jobs_file": "/farm/night.jsonl",
    "output_folder": "/farm/out",
    "bake_script": "/opt/samp/bake.py",
}


def test_settings_are_as_the_manager_knows_them():
    known = {
        "key", "type", "subtype", "choices", "propargs", "description", "default", "eval", "evalInfo", "visible",
        "required", "editable",
    }  # fmt: skip
    for setting in job_type()["settings"]:
        assert set(setting) <= known and setting["description"]
        assert setting["type"] in ("string", "int32", "float", "bool")
        assert setting["visible"] in ("visible", "hidden", "submission", "web")
        assert setting.get("default") in (*setting.get("choices", ()), setting.get("default"))
    (lines,) = [setting for setting in job_type()["settings"] if setting["key"] == "lines"]
    assert compile(lines["eval"], "eval", "eval")


@pytest.mark.parametrize(
    ("lines", "size", "chunks"),
    [
        (1, 25, ["1-1"]),
        (25, 25, ["1-25"]),
        (26, 25, ["1-25", "26-26"]),
        (5, 2, ["1-2", "3-4", "5-5"]),
        (30, None, ["1-25", "26-30"]),
    ],
)
def test_chunks_are_tasks_and_the_merge_waits_for_all(lines, size, chunks):
    *bakes, merge = compiled(**SETTINGS, lines=lines, **({} if size is None else {"chunk_size": size}))
    assert [task["name"] for task in bakes] == [f"bake-{chunk}" for chunk in chunks]
    assert all(task["dependencies"] == [] and task["type"] == "blender" for task in bakes)
    assert (merge["name"], merge["dependencies"]) == ("merge", [task["name"] for task in bakes])


def test_the_submitted_file_is_the_scene_of_lines_without_one():
    for settings, expected in (({}, False), ({"blendfile": "/farm/a.blend"}, True)):
        bake, merge = compiled(**SETTINGS, lines=1, **settings)
        arguments = bake["commands"][0]["parameters"]["args"]
        assert ("--scene" in arguments) == expected
        assert "--scene" not in merge["commands"][0]["parameters"]["args"]


@pytest.mark.parametrize("wrong", [{"lines": 0}, {"lines": 3, "chunk_size": -1}])
def test_settings_that_cannot_be_used(wrong):
    with pytest.raises(quickjs.JSException, match="at least 1"):
        compiled(**SETTINGS | wrong)


def test_the_commands_bake_and_merge(room, tmp_path):
    """`{blender}` is a script that understands Blender's arguments and runs the Python module instead."""
    scene, start = room
    shutil.copy(scene, tmp_path / "room.blend")
    shared = {"scene": "room.blend", "action": "sit", "target": "Sofa", "start": [float(v) for v in start]}
    jobs = tmp_path / "night.jsonl"
    jobs.write_text("".join(json.dumps(shared | {"seed": seed, "hold": 0.5}) + "\n" for seed in (1, 2, 3)))
    blender = tmp_path / "blender"
    blender.write_text(f'#!/bin/sh\n[ "$1 $2 $3 $4" = "--background --python-exit-code 1 --python" ] || exit 3\n'
                       f'script=$5\nshift 5\nexec "{sys.executable}" "$script" "$@"\n')  # fmt: skip
    blender.chmod(0o755)
    tasks = compiled(
        jobs_file=str(jobs),
        lines=3,
        chunk_size=2,
        output_folder=str(tmp_path / "out"),
        bake_script=str(FAKES),
    )
    for task in tasks:
        for command in task["commands"]:
            assert command["name"] == "exec"
            words = [command["parameters"]["exe"], *command["parameters"]["args"]]
            words = [word.replace("{blender}", str(blender)) for word in words]
            done = subprocess.run(words, cwd="/", capture_output=True, text=True, timeout=200, check=False)
            assert (done.returncode, done.stderr) == (0, ""), task
    assert [row["line"] for row in load(tmp_path / "out" / "report.json")["variants"]] == [1, 2, 3]
    assert len(list((tmp_path / "out" / "npz").iterdir())) == 3
    assert (tmp_path / "out" / "index.html").is_file() and (tmp_path / "out" / "takes.csv").is_file()
