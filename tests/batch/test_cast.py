"""A cast in the batch: several characters in one file, each with an Action of its own."""

from __future__ import annotations

import json

import bpy
import pytest
from batch_runs import bake, load
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.errors import UsageError

SIT = {"action": "sit", "target": "Sofa"}


def test_two_on_a_sofa(room, tmp_path):
    scene, start = room
    numbers = [float(v) for v in start]
    entries = [
        SIT | {"name": "Ann", "start": numbers},
        SIT | {"name": "Bob", "delay": 1.5, "look_at": "Ann"},
        {"action": "walk", "to": [numbers[0] + 1.0, numbers[1], 0.0], "start": numbers[:2] + [0, 0]},
    ]
    entries[2]["start"][0] -= 1.0
    (tmp_path / "cast.json").write_text(json.dumps(entries))
    options = ["--scene", scene, "--cast", tmp_path / "cast.json", "--hold", 1, "--seed", 2]
    files = ["--output", tmp_path / "out.blend", "--report", tmp_path / "r.json", "--npz", tmp_path / "npz"]
    status, said, complained = bake(*options, *files)
    assert (status, complained) == (0, "")
    assert "3 characters" in said
    (variant,) = load(tmp_path / "r.json")["variants"]
    cast = variant["cast"]
    assert [each["character"] for each in cast] == ["Ann", "Bob", "Character 3"]
    assert cast[1]["sets_off"] >= cast[1]["delay"] == 1.5
    assert {each["frame_end"] for each in cast} == {variant["frame_end"]}
    one, two = (each["goal_position"] for each in cast[:2])
    assert sum((a - b) ** 2 for a, b in zip(one, two, strict=True)) ** 0.5 > 0.5
    # The fake takes are in the T-pose, so the arms overlap on the sofa; a warning reports it.
    told = any("is up to" in text for text in variant["warnings"])
    assert told == (variant["overlap_frames_percent"] > 0)
    assert len(list((tmp_path / "npz").iterdir())) == 3
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    for each in cast:
        assert bpy.data.objects[each["armature"]].animation_data.action.name == each["action_name"]


def test_a_cast_in_a_jobs_file(room, tmp_path):
    scene, _ = room
    jobs, report = tmp_path / "jobs.jsonl", tmp_path / "r.json"
    lines = [
        {"cast": [SIT, SIT], "npz": str(tmp_path / "npz")},
        {"cast": [SIT, {"action": "sit", "target": "Sofas", "name": "Eve"}], "npz": str(tmp_path / "b")},
    ]
    jobs.write_text("".join(json.dumps(line) + "\n" for line in lines))
    options = ["--scene", scene, "--jobs", jobs, "--report", report, "--hold", 0.5]
    status, _, complained = bake(*options)
    assert status == 1
    assert "'Eve'" in complained and "'Sofa'" in complained and "Traceback" not in complained
    assert len(load(report)["variants"][0]["cast"]) == 2
    status, said, _ = bake(*options)
    assert "1/2 done before" in said


@pytest.mark.parametrize(
    ("cast", "message"),
    [
        ([], "0 members"),
        ("none.json", "cannot be read"),
        (3, "list of objects"),
        ([3], "list of objects"),
        ([{"action": "sit"}], "'Character 1': Name what to sit on"),
        ([{"action": "sit", "target": "Sofa", "name": "Ann", "delay": -1}], "'Ann': the delay is -1"),
        ([{"action": "sit", "target": "Sofa", "delay": "soon"}], "'Character 1': 'delay' cannot be"),
        ([{"action": "fly", "target": "Sofa"}], "'Character 1': There is no action 'fly'"),
        ([SIT | {"output": "x.blend"}], "'output' is an option of the whole job"),
        ([SIT | {"colour": "red"}], "'Character 1': There is no option 'colour'"),
        ([SIT | {"character": "A"}, SIT | {"character": "A"}], "'A' is in the cast twice"),
    ],
)
def test_unusable_casts(cast, message):
    with pytest.raises(UsageError, match=message):
        order({"cast": cast, "report": "r.json"})


def test_entries_take_over_the_jobs_options():
    shared = {"report": "r.json", "seed": 7, "hold": 3.0, "action": ["sit"], "target": ["Bench"]}
    entries = [
        {},
        {"action": "walk", "to": [1, 2, 0], "seed": 3, "speed": 1.5},
        {"targets": ["A", "B"], "action": "sit"},
    ]
    made = order(shared | {"cast": entries})
    first, second, third = made.job.members
    assert (first.job.action, first.job.target, first.job.hold) == ("sit", "Bench", 3.0)
    assert (second.job.to, second.job.target, second.job.speed) == ((1.0, 2.0, 0.0), "", 1.5)
    assert third.targets == ("A", "B")
    assert [made.job.member_seed(7, k) for k in range(3)] == [7, 3, 7 + 2 * 7919]
    assert made.options() == order(shared | {"cast": entries}).options()
    assert made.options() != order(shared | {"cast": entries[:2]}).options()
