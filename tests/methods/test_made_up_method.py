"""A method that no file of the program knows, with neither goal nor way-points, goes everywhere that takes go."""

from __future__ import annotations

import json

import bpy
import fakes
import numpy as np
import pytest
import rooms
import samp_blender
from samp_blender.samp_addon.batch import command_line, main
from samp_blender.samp_addon.blender.actions import notes
from samp_blender.samp_addon.blender.takes import take_list
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.methods import registry
from samp_blender.samp_addon.methods.method import Option
from samp_blender.samp_addon.methods.take import Failure, Take
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.refine import refinement
from samp_blender.samp_addon.ui import method_options


class Bounce:
    """Stands on a spot, and goes up and down."""

    name = "bounce"
    label = "Bounce"
    description = "Go up and down on the spot"
    actions = ()
    needs = frozenset({"start"})
    options = (
        Option("height", "how high it goes, metres", default=0.1, minimum=0.0, maximum=1.0),
        Option("mood", "how it looks", kind=str, metavar=("MOOD",)),
        Option("limbs", "what moves", kind=str, metavar=("LIMBS",), choices=("left_arm", "legs", "head")),
        Option("spots", "places that it passes", metavar=("X", "Y", "Z"), repeated=True),
    )
    batch_size = 2

    def __init__(self):
        self.loaded, self.draws, self.moods, self.limbs = 0, [], [], []

    def check(self, step):
        if step.target:
            raise UsageError("Bounce needs no --target; leave it out.")

    def load(self):
        self.loaded += 1

    def generate(self, step, scene, draws, progress):
        self.draws.append(list(draws))
        self.moods.append(step.settings.get("mood"))
        self.limbs.append(step.settings.get("limbs"))
        takes, failures = [], []
        for count, draw in enumerate(draws):
            progress("Bouncing", count / len(draws))
            if draw.seed == 13:
                failures.append(Failure(13, "Thirteen is unlucky; choose another seed."))
                continue
            time = np.arange(60) / 30
            height = 0.93 + step.settings.get("height", 0.1) * np.sin(time * (3 + draw.noise % 5)) ** 2
            place = np.zeros(3) if scene.start is None else scene.start[0]
            before = scene.after.get(draw.seed)
            place = place if before is None else before.below_end
            root = np.stack([np.full(60, place[0]), place[1] + height, np.full(60, place[2])], -1)
            still = np.tile([1.0, 0.0, 0.0, 0.0], (60, 22, 1))
            takes.append(Take(draw.seed, Motion(root, still), method=self.name, seconds={"bounce": 0.1}))
        return takes, failures


@pytest.fixture(autouse=True)
def method(monkeypatch):
    made = Bounce()
    monkeypatch.setitem(registry.METHODS, made.name, made)
    monkeypatch.setattr(refinement, "refine", fakes.refine)
    return made


@pytest.fixture
def room(tmp_path):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.context.view_layer.update()
    path = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


@pytest.fixture
def addon(method):
    samp_blender.register()
    yield
    samp_blender.unregister()


def test_command_line_report_and_files(room, tmp_path, method, capfd):
    arguments = ["--scene", room, "--method", "bounce", "--start", 0, 3, 0, 90, "--seed", 11, "--variants", 4]
    outputs = ["--refine", "--npz", tmp_path / "npz", "--report", tmp_path / "r.json"]
    own = ["--height", "0.2", "--mood", "glad", "--spots", 0, 0, 0, "--spots", 1, 0, 0]
    assert main.main([str(part) for part in (*arguments, *own, *outputs)]) == 1
    report = json.loads((tmp_path / "r.json").read_text())
    assert [variant["seed"] for variant in report["variants"]] == [11, 12, 14]
    assert report["errors"] == [{"seed": 13, "message": "Thirteen is unlucky; choose another seed."}]
    for variant in report["variants"]:
        assert variant["method"] == "bounce"
        nothing = ("action", "target", "goal_position", "goal_direction", "waypoints", "interaction_start")
        assert all(variant[name] is None for name in (*nothing, "sub_goals", "camera"))
        assert "position_error_cm" not in variant["metrics"] and variant["metrics"]["jerk_m_s3"] > 0
        assert variant["refined"]["after"]["contact"] == 1 and variant["seconds"]["bounce"] > 0
    assert len(list((tmp_path / "npz").iterdir())) == 3
    assert "seed 11, 2.0 s" in capfd.readouterr().out
    # In batches of its size; what failed is tried again, and no more than that.
    assert [[draw.seed for draw in draws] for draws in method.draws] == [[11, 12], [13, 14], [13], [13]]
    assert len({draws[-1].noise for draws in method.draws[2:]}) == 2 and method.moods[0] == "glad"


def test_help_and_the_jobs_file_know_its_options(tmp_path, room):
    assert "--height" in command_line.parser().format_help()
    assert ", ".join(registry.METHODS) in " ".join(command_line.parser().format_help().split())
    lines = [
        {"method": "bounce", "height": 0.3, "spots": [[0, 0, 0], [1, 1, 0]], "npz": "out"},
        {"method": "bounce", "height": 7, "npz": "out2"},
        {"method": "bounce", "target": "Sofa", "npz": "out3"},
        {"method": "samp", "action": "idle", "height": 0.3, "npz": "out4"},
    ]
    jobs = tmp_path / "jobs.jsonl"
    jobs.write_text("\n".join(json.dumps(line | {"npz": str(tmp_path / line["npz"])}) for line in lines))
    status = main.main(["--jobs", str(jobs), "--scene", str(room), "--report", str(tmp_path / "r.json")])
    report = json.loads((tmp_path / "r.json").read_text())
    assert status == 1 and [variant["line"] for variant in report["variants"]] == [1]
    assert report["variants"][0]["job"]["settings"]["spots"] == [[0, 0, 0], [1, 1, 0]]
    assert [error["message"] for error in report["errors"]] == [
        "--height is 7; choose from 0 to 1.",
        "Bounce needs no --target; leave it out.",
        "The method 'samp' has no option 'height'; leave it out.",
    ]


def test_the_panel_the_list_measures_refinement_and_export(addon, room, tmp_path, method):
    settings = bpy.context.scene.samp
    assert [item[0] for item in method_options.items(settings, bpy.context)] == list(registry.METHODS)
    settings.method, settings.bounce_height, settings.bounce_mood = "bounce", 0.3, "sad"
    assert bpy.ops.samp.generate.poll()  # without a target
    assert bpy.ops.samp.generate() == {"FINISHED"}
    assert method.moods == ["sad"] and method.limbs == [None]
    settings.bounce_limbs = {"head", "left_arm"}
    assert bpy.ops.samp.generate() == {"FINISHED"}
    assert method.limbs[-1] == "left_arm,head"
    bpy.ops.samp.delete_take(action_name=take_list.takes()[-1].name)
    person = settings.character
    (take,) = take_list.takes()
    assert take.name == "Bounce 0" and "foot_slide_cm_s" in notes.read_measures(take)
    assert bpy.ops.samp.measure(character=person.name) == {"FINISHED"}
    assert bpy.ops.samp.export_npz(filepath=str(tmp_path / "take.npz"), character=person.name) == {"FINISHED"}
    with np.load(tmp_path / "take.npz") as data:
        assert data["trans"].shape == (48, 3)  # at 24 frames a second
    assert bpy.ops.samp.refine(character=person.name) == {"FINISHED"}
    assert person.animation_data.action.name == "Bounce 0 refined"
    assert bpy.ops.samp.export_take(filepath=str(tmp_path / "take.bvh"), kind="BVH") == {"FINISHED"}
    assert bpy.ops.samp.star_take(action_name="Bounce 0") == {"FINISHED"}


def test_steps_of_two_methods_in_one_take(addon, room):
    """A walk by SAMP goes on where a bounce ended, which knows no floor."""
    from samp_blender.samp_addon.blender.takes import baking
    from samp_blender.samp_addon.methods.step import Step

    job = Job(
        action="", method="bounce", start=(0.0, 3.0, 0.0, 90.0),
        then=(Step(action="walk", to=(0.0, 2.0, 0.0)), Step(action="", method="bounce")),
    )  # fmt: skip
    tools = fakes.toolbox()
    both = type(tools)({**registry.METHODS, **tools.methods}, tools.refine)
    result = baking.run(bpy.context, job, tools=both)
    (variant,) = result.variants
    assert variant["method"] == "bounce,samp" and [step["method"] for step in variant["steps"]] == [
        "bounce", "samp", "bounce",
    ]  # fmt: skip
    assert variant["goal_position"] is None and variant["steps"][1]["goal_position"] is not None
    assert variant["waypoints"][0][:2] == pytest.approx([0.0, 3.0], abs=0.1)


def test_methods_that_are_not_there():
    known = ", ".join(registry.METHODS)
    assert "samp" in known and "bounce" in known
    with pytest.raises(UsageError, match=f"There is no method 'magic'; choose one of {known}"):
        Job(action="idle", method="magic")
