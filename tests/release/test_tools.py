"""Tools run by hand or by make: the demo, the evaluation, the random rooms, the check for system packages."""

from __future__ import annotations

import importlib
import json
import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.blender.render import workbench
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.methods.samp.networks import Networks
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.scene.navmesh import navmesh, path
from samp_blender.samp_addon.scene.seats import seats
from samp_blender.training.evaluation import reference, refined, report, sheets, tables, takes

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def demo():
    sys.path.insert(0, str(ROOT / "demo"))
    yield importlib.import_module("make_demo")
    sys.path.remove(str(ROOT / "demo"))


@pytest.mark.skipif(not workbench.offscreen_works(), reason="no libEGL here")
def test_the_demo_writes_its_files(demo, tmp_path, monkeypatch):
    monkeypatch.setattr(demo, "FILM_STEP", 40)
    monkeypatch.setattr(demo, "FILM_SIZE", (160, 90))
    monkeypatch.setattr(demo, "VIEWS", demo.VIEWS[:1])
    monkeypatch.setattr(demo, "TILES", 2)
    pytest.importorskip("imageio_ffmpeg")
    assert demo.main(tmp_path, fakes.TOOLS) == 0
    names = {p.name for p in tmp_path.iterdir()}
    sheets = {"sit_sofa_1.png", "sit_sofa_2.png", "sit_sofa_3.png", "walk_1.png"}
    assert names == sheets | {"demo.blend", "demo.mp4", "report.json"}
    variants = json.loads((tmp_path / "report.json").read_text())["variants"]
    assert [v["action"] for v in variants] == ["sit", "sit", "sit", "walk"]
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "demo.blend"))
    assert bpy.data.objects["Human"].animation_data.action.name == "sit Sofa 1"
    assert bpy.context.scene.frame_end == max(v["frame_end"] for v in variants)


@pytest.mark.parametrize("name", ["Sofa", "Armchair"])
def test_the_demo_room_has_reachable_seats(demo, name):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    demo.build_room.build(bpy.context.scene)
    scene = read_scene.read_scene(bpy.context)
    target = read_scene.read_target(bpy.context, name)
    goal = seats.find_goals(target.triangles, "sit", obstacles=scene.without(target.parts).triangles)[0]
    start = np.array([2.0, 0.0, 2.0])
    assert path.plan_to_goal(navmesh.build(scene.triangles), start, goal).length > 2


@pytest.mark.parametrize("seed", range(4))
def test_random_rooms_have_a_path_around_an_obstacle(seed):
    room = rooms.random_room(seed)
    assert len(room.pieces) == 6
    goal = seats.find_goals(room.target.triangles, "sit")[0]
    straight = room.crossings([room.start, goal.position])
    assert "Obstacle 1" in straight
    way = path.plan_to_goal(navmesh.build(room.triangles), room.start, goal).waypoints
    assert room.crossings(way) == []


def test_evaluation_tables(tmp_path):
    results = takes.evaluate("sit", 1, 2, [], fakes.NETWORKS)
    text = report.table("sit", results, [take.motion for take in results.takes])
    assert text.startswith("sit: 2 takes of 2 asked for")
    assert "| success | 2 of 2 (34% to 100%) |" in text
    assert "| foot slide, cm/s |" in text and "| 6.09 | <= 4 |" in text
    ratios = reference.execution_ratios(results, (2.0, 1.0))
    assert len(ratios) == 2 and all(0.2 < ratio < 5 for ratio in ratios)
    assert "| execution time over real |" in report.table("sit", results, [], (2.0, 1.0))
    assert reference.real_pace([tmp_path / "nowhere"]) is None
    said = []
    stuck = takes.evaluate("sit", 1, 2, [], Networks(fakes.sample_goals, fakes.never), said.append)
    assert report.table("sit", stuck, []) == "sit: 0 takes of 2 asked for" and len(said) == 2
    assert takes.held_out_seats(tmp_path) == []
    comparison = report.comparison("sit", {"ours": results, "stuck": stuck}, []).splitlines()
    assert comparison[2].startswith("| ours | 2 of 2 | ") and comparison[3].startswith(
        "| stuck | 0 of 2 | - | "
    )
    assert len({line.count("|") for line in comparison}) == 1


def test_evaluation_table_of_refinement():
    results = takes.evaluate("sit", 1, 1, [], fakes.NETWORKS)
    result = refined.mend(results.takes[0], results.scenes[0])
    assert result.after["penetration_max_cm"] < result.before["penetration_max_cm"]
    text = refined.table("sit", [result, result])
    assert "| seconds for a second of motion |" in text and "2 takes" in text


@pytest.mark.skipif(not workbench.offscreen_works(), reason="no libEGL here")
def test_contact_sheets_of_random_takes(tmp_path, monkeypatch):
    monkeypatch.setattr(sheets, "TILES", 2)
    results = takes.evaluate("sit", 1, 3, [], fakes.NETWORKS)
    drawn = sheets.draw("sit", results, tmp_path / "new", 2)
    assert len(drawn) == 2 and all(path.stat().st_size > 1000 for path in drawn)


def test_without_the_planner_paths_are_straight():
    captured = []

    def generate(requests, progress):
        captured.extend(requests)
        return fakes.generate(requests, progress)

    networks = replace(fakes.NETWORKS, generate=generate)
    takes.evaluate("sit", 1, 1, [], networks)
    takes.evaluate("sit", 1, 1, [], takes.straight_on(networks))
    planned, straight = captured
    assert len(planned.waypoints) > 2 and len(straight.waypoints) == 2
    assert np.allclose(straight.waypoints, planned.waypoints[[0, -1]])


@pytest.mark.parametrize("action, kept", [("walk", 40), ("sit", 100)])
def test_the_walking_part_of_a_walk(action, kept):
    root = np.zeros((100, 3))
    root[:, 2] = np.clip((np.arange(100) - 30) / 30, 0, 40 / 30)
    quats = np.zeros((100, 22, 4))
    quats[..., 0] = 1
    assert len(reference.spell(Motion(root, quats), action)) == pytest.approx(kept, abs=2)


def test_intervals_of_the_tables():
    assert str(tables.Estimate.of([1.0, 2.0, 3.0])) == "2.00 ± 2.48"
    assert str(tables.Estimate.of([4.0])) == "4.00"
    with pytest.raises(ValueError, match="at least one value"):
        tables.Estimate.of([])
    low, high = tables.share(97, 100)
    assert low == pytest.approx(0.9155, abs=1e-3) and high == pytest.approx(0.9897, abs=1e-3)
    with pytest.raises(ValueError):
        tables.share(3, 2)


def test_missing_libraries_are_reported():
    check = runpy.run_path(str(ROOT / ".ci" / "check_system.py"))
    assert check["loads"]("libnowhere.so.1") is False
    script = str(ROOT / ".ci" / "check_system.py")
    code = (
        "import runpy, sys; m = runpy.run_path(sys.argv[1]); g = m['main'].__globals__;"
        "g['loads'] = lambda name: name not in ('libEGL.so.1', 'libSM.so.6');"
        "sys.argv = ['x']; sys.exit(m['main']())"
    )
    done = subprocess.run([sys.executable, "-c", code, script], capture_output=True, text=True, check=False)
    if sys.platform == "linux":
        assert done.returncode == 1
        assert done.stderr.strip().endswith("`sudo apt-get install libegl1 libsm6 libgl1-mesa-dri`.")
