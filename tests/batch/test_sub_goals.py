"""Sub-goals in the batch: on the command line, in a jobs file, and those of a saved .blend."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
import untrained
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.batch import jobs_file, main
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.sub_goals import placing, stored
from samp_blender.samp_addon.methods import registry

PLACES = [[*untrained.FLOOR, 0], [*untrained.SEAT, 180]]


@pytest.fixture(autouse=True)
def _method(monkeypatch):
    monkeypatch.setitem(registry.METHODS, "long_term", untrained.method())


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A room without sub-goals and one with two, and the pelvis of the bodies there, in Blender's world."""
    folder = tmp_path_factory.mktemp("rooms")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(registry.METHODS, "long_term", untrained.method())
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        untrained.furnish(bpy.context.scene)
        owner = character.create_character(bpy.context, location=(-0.5, 2.5, 0.0))
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "bare.blend"), copy=True)
        added = [
            placing.add(bpy.context, owner, frames.to_network(point))
            for point in (untrained.FLOOR, untrained.SEAT)
        ]
        bodies = [frames.to_blender(stored.body(arrow).root[0]) for arrow in added]
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "blocked.blend"), copy=True)
    return folder / "bare.blend", folder / "blocked.blend", bodies


def run(tmp_path, *arguments):
    report = tmp_path / "report.json"
    status = main.main(
        [*map(str, arguments), "--method", "long_term", "--hold", "0.5", "--report", str(report)]
    )
    return status, json.loads(report.read_text())


def test_a_jobs_file_has_sub_goals(tmp_path, files):
    line = {"method": "long_term", "sub_goals": PLACES, "report": "r.json"}
    job = order(jobs_file.options(json.dumps(line), {})).job
    assert job.action == "" and job.settings["sub_goals"] == tuple(tuple(place) for place in PLACES)
    jobs = tmp_path / "jobs.jsonl"
    jobs.write_text(json.dumps({"sub_goals": PLACES, "output": str(tmp_path / "out.blend")}))
    status, report = run(tmp_path, "--jobs", jobs, "--scene", files[0])
    (variant,) = report["variants"]
    assert status == 0 and len(variant["sub_goals"]) == 2 and (tmp_path / "out.blend").exists()
    assert variant["job"]["settings"]["sub_goals"] == PLACES
    for passed, place in zip(variant["sub_goals"], PLACES, strict=True):
        assert np.linalg.norm(np.array(passed["position"][:2]) - place[:2]) < 0.3


@pytest.mark.parametrize("named", [(), ("--character", "Human")])
def test_a_saved_file_bakes_with_its_bodies(tmp_path, files, named):
    status, report = run(tmp_path, "--scene", files[1], *named)
    (variant,) = report["variants"]
    assert status == 0 and variant["armature"] == "Human" and variant["action"] is None
    for passed, body in zip(variant["sub_goals"], files[2], strict=True):
        np.testing.assert_allclose(passed["position"], body, atol=1e-4)


def test_a_file_without_any(tmp_path, files, capfd):
    status, report = run(tmp_path, "--scene", files[0])
    assert status == 1 and report["errors"][0]["message"].startswith("There are no sub-goals; add some")
    assert capfd.readouterr().err.count("\n") == 1
