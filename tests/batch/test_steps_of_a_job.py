"""Several actions in one job: how they are written, and what a batch makes of them."""

import json
from pathlib import Path

import pytest
from batch_runs import bake, load
from samp_blender.samp_addon.batch import command_line, jobs_file
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.methods import registry
from samp_blender.samp_addon.methods.long_term.method import LongTerm

OUT = {"report": "r.json"}


def ordered(options):
    return order(jobs_file.options(json.dumps(options | OUT), {}))


def steps_of(options):
    return [(step.action, step.target, step.to) for step in ordered(options).job.steps]


@pytest.mark.parametrize(
    "options, steps",
    [
        ({"action": "sit", "target": "Sofa, red"}, [("sit", "Sofa, red", None)]),
        ({"action": "sit,lie", "target": "Sofa, Bed"}, [("sit", "Sofa", None), ("lie", "Bed", None)]),
        (
            {"action": ["sit", "lie"], "target": ["Sofa, red", "Bed"]},
            [("sit", "Sofa, red", None), ("lie", "Bed", None)],
        ),
        (
            {"action": "walk,sit,idle", "target": ",Sofa", "to": [1, 2, 0]},
            [("walk", "", (1.0, 2.0, 0.0)), ("sit", "Sofa", None), ("idle", "", None)],
        ),
        (
            {"action": ["walk", "run"], "to": [[1, 2, 0], [3, 4, 0, 90]]},
            [("walk", "", (1.0, 2.0, 0.0)), ("run", "", (3.0, 4.0, 0.0, 90.0))],
        ),
    ],
)
def test_steps(options, steps):
    assert steps_of(options) == steps


@pytest.mark.parametrize(
    "given, methods",
    [
        (None, ["samp", "samp", "samp"]),
        ("long_term", ["long_term", "long_term", "long_term"]),
        (["samp", "long_term", "samp"], ["samp", "long_term", "samp"]),
        ("samp,long_term,samp", ["samp", "long_term", "samp"]),
    ],
)
def test_each_step_has_a_method(monkeypatch, given, methods):
    monkeypatch.setitem(registry.METHODS, "long_term", LongTerm())
    options = {"action": "idle,sit,idle", "target": ",Sofa"} | ({"method": given} if given else {})
    made = ordered(options)
    assert [step.method for step in made.job.steps] == methods
    again = [made.options()["method"], *(step.get("method", methods[0]) for step in made.options()["then"])]
    assert again == methods


def test_the_options_of_a_method_are_for_its_steps(monkeypatch):
    monkeypatch.setitem(registry.METHODS, "long_term", LongTerm())
    places = [[0, 0, 0, 0], [1, 0, 0, 90]]
    options = {
        "action": ["idle", "", "sit"],
        "target": ["", "", "Sofa"],
        "method": ["samp", "long_term", "long_term"],
    }
    steps = ordered(options | {"sub_goals": places, "pause": 2}).job.steps
    assert [dict(step.settings) for step in steps] == [
        {}, {"sub_goals": ((0, 0, 0, 0), (1, 0, 0, 90)), "pause": 2.0}, {"pause": 2.0}
    ]  # fmt: skip
    with pytest.raises(UsageError, match="There are 2 methods for 3 actions"):
        ordered(options | {"method": ["samp", "long_term"]})
    with pytest.raises(UsageError, match="The method 'samp' has no option 'pause'"):
        ordered({"action": "idle", "pause": 2})


@pytest.mark.parametrize(
    "options, words",
    [
        ({"action": "sit,walk", "target": "Sofa"}, "Say where to walk"),
        ({"action": "sit,walk", "target": "Sofa,Door,Window"}, "3 targets for 2 actions"),
        ({"action": "walk,run", "to": [1, 2, 0]}, "1 places --to for 2 walks"),
        ({"action": "sit,fly", "target": "Sofa,Bed"}, "no action 'fly'"),
        ({"action": "sit,lie", "target": "Sofa"}, "Name what to lie on"),
        ({"action": "sit", "target": "Sofa", "then": []}, "no option 'then'"),
    ],
)
def test_steps_that_cannot_be_done(options, words):
    with pytest.raises(UsageError, match=words):
        steps_of(options)


def test_options_of_steps_are_plain_json():
    made = ordered({"action": "sit,lie", "target": "Sofa,Bed", "hold": 3})
    assert json.loads(json.dumps(made.options()))["then"] == [{"action": "lie", "target": "Bed", "to": None}]
    assert [step.hold for step in made.job.steps] == [3, 3]


def test_a_batch_bakes_all_steps_into_one_action(room, tmp_path):  # noqa: F811
    scene, start = room
    report = tmp_path / "report.json"
    status, _, complained = bake(
        "--scene", scene, "--action", "sit,walk,sit", "--target", "Sofa,,Sofa", "--to", *start[:3],
        "--start", *start, "--hold", 0.5, "--report", report, "--npz", tmp_path / "npz",
    )  # fmt: skip
    assert (status, complained) == (0, "")
    (variant,) = load(report)["variants"]
    assert (variant["action"], variant["target"]) == ("sit,walk,sit", "Sofa,,Sofa")
    ends = [step["frame_end"] for step in variant["steps"]]
    assert ends == sorted(ends) and ends[-1] == variant["frame_end"]
    assert variant["interaction_start"] > ends[1]
    assert variant["action_name"] == "sit Sofa, walk, sit Sofa 0"
    assert [path.name for path in Path(tmp_path / "npz").iterdir()] == ["room_sit_Sofa_walk_sit_Sofa_0.npz"]


@pytest.mark.parametrize(
    "shape", [{"height": 1.8, "gender": "male"}, ["height=1.8", "gender=male"], ["height=1.80", "gender=1"]]
)
def test_a_shape_of_the_body(shape):
    made = ordered({"action": "idle", "shape": shape})
    assert dict(made.job.shape) == {"height": 1.8, "gender": 1.0}
    assert made.options()["shape"] == {"height": 1.8, "gender": 1.0}
    assert "shape" not in ordered({"action": "idle"}).options()
    line = command_line.parse(["--action", "idle", "--shape", "height=1.8", "--shape", "gender=male"])
    assert order(line | {"report": "r.json"}).job.shape == made.job.shape


@pytest.mark.parametrize(
    "options, words",
    [
        ({"shape": {"height": 3}}, "Height is 3 m"),
        ({"shape": {"hat": 3}}, "--shape has no 'hat'"),
        ({"shape": "tall"}, "write NAME=VALUE"),
        ({"shape": {"height": [1]}}, "--shape cannot be"),
        ({"shape": {"height": 1.8}, "character": "Anna"}, "leave out --character"),
    ],
)
def test_shapes_that_cannot_be(options, words):
    with pytest.raises(UsageError, match=words):
        ordered({"action": "idle"} | options)
