"""Send to Farm: what it writes is what the generate button would make here; the artist's file stays as it is."""

from __future__ import annotations

import json
import os
import sys
import time
from types import SimpleNamespace

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.operators.send_to_farm import SAMP_OT_send_to_farm
from samp_blender.operators.thread_operator import ThreadOperator
from samp_blender.samp_addon.batch import jobs_file, main
from samp_blender.samp_addon.batch.farm.sending import packing
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.blender import running_work
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.body import amass
from samp_blender.samp_addon.methods.samp import networks
from screen import Screen

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def saved(tmp_path, monkeypatch):
    """A saved room with a character; networks that are fakes."""
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    start = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    character.create_character(bpy.context, location=tuple(start[:3]), yaw=1.0, name="Ann")
    settings = bpy.context.scene.samp
    settings.action, settings.target = "sit", bpy.data.objects["Sofa"]
    settings.seed, settings.hold, settings.speed = 5, 0.5, 1.25
    settings.farm.takes, settings.farm.per_line = 3, 2
    path = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def sent(folder):
    """Return the orders of a bundle's jobs file."""
    return [order(jobs_file.options(text, {})) for _, text in jobs_file.lines(folder / "jobs.jsonl")]


def test_a_farm_makes_the_takes_of_the_button(saved, tmp_path, monkeypatch):
    before = saved.read_bytes()
    assert bpy.ops.samp.send_to_farm() == {"FINISHED"}
    (folder,) = (tmp_path / "farm").iterdir()
    assert saved.read_bytes() == before and bpy.data.filepath == str(saved)
    assert bpy.context.scene.samp.seed == 8
    assert [(list(each.job.seeds), each.job.character) for each in sent(folder)] == [
        ([5, 6], "Ann"),
        ([7], "Ann"),
    ]

    scene = bpy.context.scene
    scene.samp.seed, scene.samp.variants = 5, 1
    assert bpy.ops.samp.generate() == {"FINISHED"}
    owner = bpy.data.objects["Ann"]
    here = keyframes.read_motion(owner, owner.animation_data.action, scene=scene)
    status = main.main(
        [
            "--jobs",
            str(folder / "jobs.jsonl"),
            "--relative-to",
            str(folder),
            "--report",
            str(tmp_path / "r.json"),
        ],
        fakes.TOOLS,
    )
    assert status == 0
    first = json.loads((tmp_path / "r.json").read_text())["variants"][0]
    there = amass.read_amass(first["npz"])
    assert (first["armature"], first["seed"]) == ("Ann", 5)
    np.testing.assert_allclose(there.root, here.root, atol=1e-5)


@pytest.mark.parametrize(
    ("what", "jobs"),
    [
        ({"each_selected": True}, [("sit", "Sofa"), ("sit", "Table")]),
        (
            {"what": "STEPS"},
            [
                ("walk", ""),
            ],
        ),
        ({"what": "CAST"}, [("sit", "Sofa")]),
    ],
)
def test_which_jobs_are_sent(saved, tmp_path, what, jobs):
    scene = bpy.context.scene
    table = bpy.data.objects["Sofa"].copy()
    table.name = "Table"
    scene.collection.objects.link(table)
    for obj in scene.objects:
        obj.select_set(obj.name in ("Sofa", "Table"))
    bpy.context.view_layer.objects.active = bpy.data.objects["Sofa"]
    bpy.ops.samp.edit_chain(change="ADD")
    step = scene.samp.steps[0]
    step.action, step.target, step.place = "walk", None, (1.0, 2.0, 0.0)
    bpy.ops.samp.edit_cast(change="ADD")
    member = scene.samp.cast[0]
    member.character, member.action, member.target = bpy.data.objects["Ann"], "sit", bpy.data.objects["Sofa"]
    for name, value in what.items():
        setattr(scene.samp.farm, name, value)
    scene.samp.farm.takes = 1
    assert bpy.ops.samp.send_to_farm(folder=str(tmp_path / "out")) == {"FINISHED"}
    made = [each.job for each in sent(tmp_path / "out")]
    firsts = [job.members[0].job if what.get("what") == "CAST" else job for job in made]
    assert [(job.action, job.target) for job in firsts] == jobs
    assert all(job.character == "Ann" and job.start is not None for job in firsts)


def test_a_command_is_run_with_the_jobs_file(saved, tmp_path):
    record = tmp_path / "words.txt"
    command = f"{sys.executable} -c \"import sys; open('{record}', 'w').write(sys.argv[1])\" {{jobs}}"
    folder = tmp_path / "out"
    assert bpy.ops.samp.send_to_farm(folder=str(folder), engine="COMMAND", command=command) == {"FINISHED"}
    assert record.read_text() == str(folder / "jobs.jsonl")


@pytest.mark.parametrize(
    ("options", "settings", "reason"),
    [
        ({"engine": "FLAMENCO"}, {}, "online access is off"),
        ({"engine": "COMMAND"}, {}, "no command line"),
        ({}, {"start_from": "POSE"}, "cannot continue"),
        ({"folder": os.path.dirname(__file__)}, {}, "is not empty"),
    ],
)
def test_what_cannot_be_sent(saved, tmp_path, options, settings, reason):
    if options.get("engine") == "FLAMENCO" and bpy.app.online_access:
        pytest.skip("Blender's online access is on here")
    for name, value in settings.items():
        setattr(bpy.context.scene.samp, name, value)
    with pytest.raises(RuntimeError, match=reason):
        bpy.ops.samp.send_to_farm(**options)
    assert not (tmp_path / "farm").exists()


def test_relative_names_lead_where_they_led(saved, tmp_path):
    picture = bpy.data.images.new("wood", 4, 4)
    picture.filepath_raw, picture.file_format = str(tmp_path / "wood.png"), "PNG"
    picture.save()
    picture.filepath, picture.use_fake_user = "//wood.png", True
    bpy.ops.wm.save_mainfile()
    assert bpy.ops.samp.send_to_farm(folder=str(tmp_path / "deep" / "out")) == {"FINISHED"}
    assert picture.filepath == "//wood.png"
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "deep" / "out" / "scene.blend"))
    found = bpy.data.images["wood"].filepath
    assert found.startswith("//") and os.path.samefile(bpy.path.abspath(found), tmp_path / "wood.png")


@pytest.mark.parametrize("packed", [False, pytest.param(True, marks=pytest.mark.skipif(
    not packing.available(), reason="blender-asset-tracer is not installed"))])  # fmt: skip
def test_linked_files(saved, tmp_path, monkeypatch, packed):
    monkeypatch.setattr(packing, "available", lambda: packed)
    library = tmp_path / "sets" / "lamp.blend"
    library.parent.mkdir()
    mesh = bpy.data.meshes.new("Lamp")
    bpy.data.libraries.write(str(library), {bpy.data.objects.new("Lamp", mesh)})
    with bpy.data.libraries.load(str(library), link=True, relative=True) as (_, wanted):
        wanted.objects = ["Lamp"]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    bpy.ops.wm.save_mainfile()
    folder = tmp_path / "out"
    assert bpy.ops.samp.send_to_farm(folder=str(folder)) == {"FINISHED"}
    (scene,) = {each.scene for each in sent(folder)}
    bpy.ops.wm.open_mainfile(filepath=str(folder / scene))
    found = os.path.realpath(bpy.path.abspath(bpy.data.libraries[0].filepath))
    assert found.startswith(str(folder)) if packed else found == str(library)
    assert bpy.data.objects["Lamp"].library is not None and not bpy.data.objects["Lamp"].is_missing


class Pressed(ThreadOperator):
    """Blender's side of the operator beside a window."""

    bl_label, address, engine, reports = "Send to Farm", "", "COMMAND", ()
    begin, finished = SAMP_OT_send_to_farm.begin, SAMP_OT_send_to_farm.finished
    _prepared, _folder, _engine = (
        vars(SAMP_OT_send_to_farm)[name] for name in ("_prepared", "_folder", "_engine")
    )

    def __init__(self, folder, command):
        self.folder, self.command, self.reports = str(folder), command, []

    def report(self, kind, text):
        self.reports.append((kind, text))


@pytest.mark.parametrize(("ends", "seconds"), [("done", 0.2), ("ESC", 60)])
def test_the_window_goes_on_while_a_program_submits(saved, tmp_path, ends, seconds):
    program = f"import time; print('queued', flush=True); time.sleep({seconds})"
    operator = Pressed(tmp_path / "out", f'{sys.executable} -c "{program}"')
    window, until, came = Screen(), time.monotonic() + 120, {"PASS_THROUGH"}
    operator._begin(window)
    tick, escape = (SimpleNamespace(type=kind, value="PRESS") for kind in ("TIMER", "ESC"))
    while came & {"PASS_THROUGH", "RUNNING_MODAL"} and time.monotonic() < until:
        submitting = "Submitting" in (window.status or "")
        came = operator.modal(window, escape if ends == "ESC" and submitting else tick)
        time.sleep(0.02)
    assert came == ({"FINISHED"} if ends == "done" else {"CANCELLED"})
    said = "Sent 2 jobs: queued" if ends == "done" else "Stopped; nothing was changed."
    assert operator.reports == [({"INFO"}, said)]
    assert (window.timers, window.status, running_work.current()) == ([], None, None)
    assert len(sent(tmp_path / "out")) == 2
