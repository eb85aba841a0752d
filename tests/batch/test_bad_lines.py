"""Whatever stands in a jobs file ends as one sentence, and the next line runs."""

from __future__ import annotations

import json

import pytest
from batch_runs import bake, load
from samp_blender.samp_addon.batch import jobs_file
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.errors import SampError

SIT = {"action": "sit", "target": "Sofa", "report": "r.json"}


def line(**changes):
    return json.dumps({name: value for name, value in (SIT | changes).items() if value is not ...})


BAD = {
    "not JSON": "{not json",
    "half a line": '{"action": "sit", "tar',
    "a list": "[1, 2]",
    "a number": "5",
    "a text": '"sit"',
    "null": "null",
    "nothing in it": "{}",
    "two objects": line() + line(),
    "deep lists": "[" * 100_000,
    "a number of 5,000 digits": '{"seed": ' + "1" * 5000 + "}",
    "an unknown option": line(colour="red"),
    "an unknown option of 10 MB": json.dumps(SIT | {"x" * 10_000_000: 1}),
    "help": line(help=True),
    "another jobs file": line(jobs="other.jsonl"),
    "to is a number": line(to=5, action="walk", target=...),
    "to is empty": line(to=[], action="walk", target=...),
    "to is empty with several actions": line(to=[], action="walk,sit", target=",Sofa"),
    "to is text": line(to="here", action="walk", target=...),
    "to holds text": line(to=["a", "b", "c"], action="walk", target=...),
    "to holds null": line(to=[1, None, 0], action="walk", target=...),
    "to holds not-a-number": '{"action": "walk", "to": [NaN, 1, 0], "report": "r.json"}',
    "to holds infinity": '{"action": "walk", "to": [-Infinity, 1, 0], "report": "r.json"}',
    "to is nested too deeply": line(to=[[[1, 2, 0]]], action="walk", target=...),
    "two places for one walk": line(to=[[1, 2, 0], [3, 4, 0]], action="walk", target=...),
    "to with an object": line(to={"x": 1}, action="walk", target=...),
    "a very negative place": line(to=[-1e300, -1e-300, 0, 0, 0], action="walk", target=...),
    "no action": line(action=...),
    "an empty list of actions": line(action=[]),
    "an empty action": line(action=""),
    "an action that is a number": line(action=5),
    "a nested list of actions": line(action=[["sit"]]),
    "an unknown action": line(action="dance"),
    "a target that is a number": line(target=5),
    "a target that is a list of numbers": line(target=[1]),
    "a target with half a surrogate pair": '{"action": "sit", "target": "\\ud800", "report": "r.json"}',
    "a target of 10 MB": line(target="x" * 10_000_000),
    "seed is not-a-number": '{"action": "idle", "seed": NaN, "report": "r.json"}',
    "seed is infinite": '{"action": "idle", "seed": 1e999, "report": "r.json"}',
    "seed is a fraction": line(seed=1.5),
    "seed is text": line(seed="1"),
    "seed is true": line(seed=True),
    "seed is too large": line(seed=2**31),
    "no variants": line(variants=0),
    "endless hold": '{"action": "idle", "hold": 1e999, "report": "r.json"}',
    "refine is text": line(refine="yes"),
    "start is short": line(start=[1, 2]),
    "start is nested": line(start=[[1, 2], [3, 4]]),
    "via is short": line(via=[1, 2]),
    "via is mixed": line(via=[[1, 2, 3], 4]),
    "an unknown method": line(method="magic"),
    "a scene that is a number": line(scene=3),
    "a scene that is not there": line(scene="nowhere.blend"),
    "an output that is no .blend": line(output="a.png"),
    "an output with a zero byte": line(output="a\0.blend"),
    "an empty output": line(output=""),
}


@pytest.mark.parametrize("name", [name for name in BAD if "scene that is not" not in name])
def test_a_bad_line_is_one_sentence(name):
    """Most lines are refused before any scene is opened, in a short sentence."""
    try:
        made = order(jobs_file.options(BAD[name], {}))
    except SampError as error:
        assert str(error).endswith(".") and len(str(error)) < 700
        assert "\n" not in str(error) and "Traceback" not in str(error)
    else:
        assert "target" in name and made.job.target  # an object of this name may exist


def test_the_next_line_runs_and_nothing_is_a_traceback(room, tmp_path):
    scene, start = room
    good = line(scene=str(scene), start=[float(v) for v in start], npz="npz", report=...)
    text = "\n".join([*BAD.values(), good])
    (tmp_path / "night.jsonl").write_text(text, encoding="utf-8")
    status, said, complained = bake(
        "--jobs", "night.jsonl", "--scene", scene, "--report", "r.json", cwd=tmp_path
    )
    assert status == 1 and "Traceback" not in complained
    assert said.splitlines()[-1] == f"bake: {len(BAD) + 1}/{len(BAD) + 1} done"
    lines = complained.splitlines()
    assert len(lines) == len(BAD) and all(len(text) < 700 for text in lines)
    assert [error["line"] for error in load(tmp_path / "r.json")["errors"]] == list(range(1, len(BAD) + 1))
    assert len(list((tmp_path / "npz").iterdir())) == 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends(tmp_path, encoding, end):
    path = tmp_path / "jobs.jsonl"
    path.write_bytes((line(target="Stühle\u2028") + end + end + line(seed=1) + end).encode(encoding))
    read = jobs_file.lines(path)
    assert [number for number, _ in read] == [1, 3]
    assert order(jobs_file.options(read[0][1], {})).job.target == "Stühle\u2028"


def test_a_line_that_cannot_be_decoded_leaves_the_others(tmp_path):
    path = tmp_path / "jobs.jsonl"
    path.write_bytes(b'{"action": "idle\xff"}\n' + line().encode())
    (_, first), (_, second) = jobs_file.lines(path)
    assert isinstance(first, SampError) and "UTF-8" in str(first)
    assert json.loads(second) == SIT


@pytest.mark.parametrize(
    ("values", "shared", "found"),
    [
        ({"seed": None}, {"seed": 4}, {"seed": 0}),
        ({"seed": 2.0}, {}, {"seed": 2}),
        ({"refine": False}, {"refine": True}, {"refine": False}),
        ({}, {"refine": True}, {"refine": True}),
        ({"target": "-Sofa"}, {}, {"target": "-Sofa"}),
        ({"target": "Sofa, red"}, {}, {"target": "Sofa, red"}),
        ({"target": ["Sofa"], "action": ["sit"]}, {}, {"target": "Sofa"}),
        ({"start": [-1e-7, 0, 0, -90]}, {}, {"start": (-1e-7, 0.0, 0.0, -90.0)}),
        ({"action": "walk", "to": [[1, 2, 0]], "target": None}, {}, {"to": (1.0, 2.0, 0.0)}),
    ],
)
def test_values(values, shared, found):
    job = order(jobs_file.options(json.dumps(SIT | values), shared)).job
    assert {name: getattr(job, name) for name in found} == found
