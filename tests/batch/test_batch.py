"""The batch as a process: exit status, standard error, report, files, and going on after a stop."""

from __future__ import annotations

import json
import os
import runpy
import subprocess
import sys

import bpy
import numpy as np
import pytest
from batch_runs import FAKES, ROOT, bake, load


def states(said):
    """What became of each job of a file, without the lines of their takes."""
    return [line.split(" ", 2)[2] for line in said.splitlines() if " take " not in line]


def test_one_job(room, tmp_path):
    scene, start = room
    out, report = tmp_path / "new folder" / "out.blend", tmp_path / "report.json"
    options = ["--scene", scene, "--action", "sit", "--target", "Sofa", "--start", *start, "--variants", 2]
    status, said, complained = bake(
        *options, "--seed", 3, "--output", out, "--report", report, "--npz", tmp_path / "npz"
    )
    assert (status, complained) == (0, "")
    assert "2 takes" in said
    variants = load(report)["variants"]
    assert [variant["seed"] for variant in variants] == [3, 4]
    assert load(report)["errors"] == []
    files = sorted(path.name for path in (tmp_path / "npz").iterdir())
    assert files == ["room_sit_Sofa_3.npz", "room_sit_Sofa_4.npz"]
    with np.load(tmp_path / "npz" / files[0]) as take:
        assert take["poses"].shape == (variants[0]["frame_end"] - variants[0]["frame_start"] + 1, 165)
    assert os.listdir(out.parent) == ["out.blend"]
    bpy.ops.wm.open_mainfile(filepath=str(out))
    owner = bpy.data.objects[variants[0]["armature"]]
    assert owner.animation_data.action.name == variants[0]["action_name"]
    assert {variant["action_name"] for variant in variants} <= set(bpy.data.actions.keys())
    bpy.context.scene.frame_set(variants[0]["frame_end"])
    pelvis = owner.matrix_world @ owner.pose.bones["pelvis"].head
    assert np.linalg.norm(np.subtract(pelvis, variants[0]["goal_position"])) < 0.2


def test_refined_takes(room, tmp_path):
    scene, start = room
    options = ["--scene", scene, "--action", "sit", "--target", "Sofa", "--start", *start, "--refine"]
    status, _, complained = bake(*options, "--report", tmp_path / "r.json", "--npz", tmp_path)
    assert (status, complained) == (0, "")
    (variant,) = load(tmp_path / "r.json")["variants"]
    assert set(variant["refined"]) == {"before", "after", "unsolved_cm"}
    assert variant["refined"]["unsolved_cm"] == 4
    with np.load(tmp_path / "room_sit_Sofa_0.npz") as take:
        assert take["trans"][-1].shape == (3,)


def test_walk_to_a_place(room, tmp_path):
    scene, start = room
    status, _, complained = bake(
        "--scene", scene, "--action", "walk", "--to", -3, -3, 0, 90, "--start", *start,
        "--report", tmp_path / "r.json",
    )  # fmt: skip
    assert (status, complained) == (0, "")
    variant = load(tmp_path / "r.json")["variants"][0]
    np.testing.assert_allclose(variant["goal_position"][:2], [-3, -3], atol=1e-4)
    np.testing.assert_allclose(variant["goal_direction"], [1, 0, 0], atol=1e-4)
    assert variant["interaction_start"] is None


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ([], "--action"),
        (["--action", "sit"], "--target"),
        (["--action", "dance", "--target", "Sofa"], "no action 'dance'"),
        (["--action", "sit", "--target", "Sofa", "--nonsense"], "--nonsense"),
        (["--action", "sit", "--target", "Sofa", "--seed", "x"], "--seed"),
        (["--action", "sit", "--target", "Sofa", "--start", "1", "2"], "X Y Z YAW"),
        (["--action", "sit", "--target", "Sofa", "--scene", "nowhere.blend"], "nowhere.blend"),
        (["--action", "sit", "--target", "Sofa", "--scene", ""], "--scene"),
        (["--action", "walk"], "--to"),
        (["--jobs", "nowhere.jsonl"], "nowhere.jsonl"),
    ],
)
def test_unusable_arguments(room, tmp_path, options, reason):
    """Through bake.py itself: none of these gets as far as the networks."""
    if "--scene" not in options and "--jobs" not in options:
        options = [*options, "--scene", room[0]]
    status, _, complained = bake(
        *options, "--report", tmp_path / "r.json", script=ROOT / "bake.py", cwd=tmp_path
    )
    assert status == 2
    assert reason in complained
    assert complained.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_no_place_for_the_result(room):
    status, _, complained = bake(
        "--scene", room[0], "--action", "sit", "--target", "Sofa", script=ROOT / "bake.py"
    )
    assert (status, complained.count("\n")) == (2, 1)
    assert "--output" in complained


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--target", "Soffa"], "'Sofa'"),
        (["--target", "Sofa", "--character", "Bob"], "Bob"),
        (["--target", "Floor"], "sit"),
    ],
)
def test_a_failed_job(room, tmp_path, options, reason):
    out, report = tmp_path / "out.blend", tmp_path / "r.json"
    status, _, complained = bake(
        "--scene", room[0], "--action", "sit", *options, "--output", out, "--report", report
    )
    assert status == 1
    assert complained.count("\n") == 1
    assert reason in complained
    found = load(report)
    assert found["variants"] == []
    assert reason in found["errors"][0]["message"]
    assert os.listdir(tmp_path) == ["r.json"]


def test_an_unreadable_scene(tmp_path):
    (tmp_path / "broken.blend").write_text("no .blend")
    status, _, complained = bake(
        "--scene", tmp_path / "broken.blend", "--action", "idle", "--report", tmp_path / "r.json"
    )
    assert (status, complained.count("\n")) == (1, 1)
    assert "broken.blend" in complained


def jobs_file(folder, room, *jobs):
    scene, start = room
    shared = {"scene": str(scene), "action": "sit", "target": "Sofa", "start": [float(v) for v in start]}
    path = folder / "night.jsonl"
    lines = [job if isinstance(job, str) else json.dumps(shared | job) for job in jobs]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_many_jobs_go_on_and_a_second_run_skips_what_is_done(room, tmp_path):
    path = jobs_file(
        tmp_path, room,
        {"output": "a.blend"},
        {"output": "b.blend", "target": "Nothing"},
        "{not json",
        {"npz": "npz", "seed": 9, "variants": 2},
        {"output": "a.blend", "seed": 1},
        {"output": "c.blend", "colour": "red"},
    )  # fmt: skip
    report = tmp_path / "r.json"
    status, said, complained = bake("--jobs", path, "--report", report, cwd=tmp_path)
    assert status == 1
    assert states(said) == ["done", "failed", "failed", "done", "failed", "failed"]
    takes = [line.split(",")[0] for line in said.splitlines() if " take " in line]
    assert takes == [
        f"bake: {take}" for take in ("1/6 take 1/1: seed 0", "4/6 take 1/2: seed 9", "4/6 take 2/2: seed 10")
    ]
    assert [line.split(":")[1].strip() for line in complained.splitlines()] == [
        f"Line {k}" for k in (2, 3, 5, 6)
    ]
    found = load(report)
    assert [(v["line"], v["seed"]) for v in found["variants"]] == [(1, 0), (4, 9), (4, 10)]
    assert [error["line"] for error in found["errors"]] == [2, 3, 5, 6]
    assert "written by line 1" in found["errors"][2]["message"]
    assert "colour" in found["errors"][3]["message"]
    first = (tmp_path / "a.blend").stat().st_mtime_ns
    (tmp_path / "npz" / "room_sit_Sofa_10.npz").unlink()

    status, said, _ = bake("--jobs", path, "--report", report, cwd=tmp_path)
    assert states(said) == ["done before", "failed", "failed", "done", "failed", "failed"]
    assert (tmp_path / "a.blend").stat().st_mtime_ns == first
    assert (tmp_path / "npz" / "room_sit_Sofa_10.npz").is_file()
    assert [(v["line"], v["seed"]) for v in load(report)["variants"]] == [(1, 0), (4, 9), (4, 10)]


def test_all_jobs_done_is_status_zero_and_a_changed_scene_is_done_again(room, tmp_path):
    scene = tmp_path / "room.blend"
    scene.write_bytes(room[0].read_bytes())
    path = jobs_file(tmp_path, (scene, room[1]), {"npz": "npz"})
    ledger = tmp_path / "night.jsonl.done"
    for expected, stir in (("done", None), ("done before", ledger), ("done", scene)):
        if stir == ledger:
            with ledger.open("a") as file:
                file.write('{"key": "cut o')  # a kill in the middle of a line
        elif stir == scene:
            os.utime(scene, ns=(1, 1))
        status, said, complained = bake("--jobs", path, cwd=tmp_path)
        assert (status, complained) == (0, "")
        assert states(said) == [expected]


def test_the_open_file_is_part_of_what_is_done(room, tmp_path):
    """A jobs file without a scene, run on one file, is not done for another one; a line's scene opens for it alone."""
    scenes = [tmp_path / "A.blend", tmp_path / "B.blend"]
    for scene in scenes:
        scene.write_bytes(room[0].read_bytes())
    lines = [{"npz": "npz"}, {"npz": "other", "scene": str(room[0])}, {"npz": "npz", "seed": 1}]
    path = jobs_file(tmp_path, room, *lines)
    path.write_text(path.read_text().replace(f'"scene": "{room[0]}", ', "", 1))
    text = [json.loads(line) for line in path.read_text().splitlines()]
    del text[2]["scene"]
    path.write_text("\n".join(map(json.dumps, text)))
    script = "import sys, bpy; bpy.ops.wm.open_mainfile(filepath=sys.argv[1]); sys.argv[1:] = sys.argv[2:];"
    for scene, expected in (
        (scenes[0], ["done", "done", "done"]),
        (scenes[1], ["done", "done before", "done"]),
        (scenes[0], ["done before"] * 3),
    ):
        run = f"{script} import runpy; runpy.run_path({str(FAKES)!r}, run_name='__main__')"
        command = [sys.executable, "-c", run, str(scene), "--jobs", str(path)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
        assert (
            states("\n".join(line for line in done.stdout.splitlines() if line.startswith("bake:")))
            == expected
        )
    names = sorted(file.name for file in (tmp_path / "npz").iterdir())
    assert names == [f"{stem}_sit_Sofa_{seed}.npz" for stem in "AB" for seed in (0, 1)]


@pytest.mark.parametrize("through_a_link", [False, True])
def test_the_scene_itself_is_not_written_over(room, tmp_path, through_a_link):
    scene = tmp_path / "room.blend"
    scene.write_bytes(room[0].read_bytes())
    output = tmp_path / "link.blend" if through_a_link else scene
    if through_a_link:
        output.symlink_to(scene)
    options = ["--scene", scene, "--action", "idle", "--start", *room[1], "--output", output]
    status, _, complained = bake(*options, cwd=tmp_path)
    assert status == 2 and "--overwrite" in complained and scene.read_bytes() == room[0].read_bytes()
    assert bake(*options, "--overwrite", cwd=tmp_path)[0] == 0
    assert output.read_bytes() != room[0].read_bytes()


def test_options_beside_a_jobs_file_are_for_all_its_lines(room, tmp_path):
    path = jobs_file(tmp_path, room, {"npz": "npz"}, {"npz": "npz", "seed": 4})
    status, _, _ = bake("--jobs", path, "--seed", 2, "--report", "r.json", cwd=tmp_path)
    assert status == 0
    assert [variant["seed"] for variant in load(tmp_path / "r.json")["variants"]] == [2, 4]


def test_an_output_that_cannot_be_written(room, tmp_path):
    (tmp_path / "file").write_text("")
    scene, start = room
    options = ["--scene", scene, "--action", "sit", "--target", "Sofa", "--start", *start]
    status, _, complained = bake(*options, "--output", tmp_path / "file" / "out.blend")
    assert (status, complained.count("\n")) == (1, 1)
    assert "--output" in complained


@pytest.mark.parametrize(
    ("command", "meant"),
    [
        (["bake.py", "--action", "sit"], ["--action", "sit"]),
        (["blender", "-b", "r.blend", "--python", "bake.py", "--", "--action", "sit"], ["--action", "sit"]),
        (["/opt/blender-4.2/blender", "-b", "r.blend", "--python", "bake.py"], []),
        (["bake.py", "--", "--action", "sit"], ["--action", "sit"]),
    ],
)
def test_arguments_under_blender_follow_two_dashes(monkeypatch, command, meant):
    monkeypatch.setattr(sys, "argv", command)
    assert runpy.run_path(str(ROOT / "bake.py"))["arguments"]() == meant


def test_every_option_stands_in_the_documentation():
    from samp_blender.samp_addon.batch import command_line

    text = (ROOT / "docs" / "batch.md").read_text(encoding="utf-8")
    for action in command_line.parser()._actions:
        for option in action.option_strings:
            assert option in ("-h", "--help") or f"`{option}" in text, option


def test_help_is_for_people():
    status, said, complained = bake("--help", script=ROOT / "bake.py")
    assert (status, complained) == (0, "")
    assert "--jobs" in said
