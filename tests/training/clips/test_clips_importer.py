"""The import command: files in, clips, catalogue and checks out."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon import skeleton
from samp_blender.training.clips import catalogue, importer, labels
from samp_blender.training.mocap import clip_files


@pytest.fixture
def folder(tmp_path):
    """Two takes of one person as BVH, one of another as .npz, and a file that is broken."""
    source = tmp_path / "source"
    source.mkdir()
    recordings.write_bvh(source / "07_01.bvh", recordings.walk(60))
    recordings.write_bvh(source / "07_02.bvh", recordings.walk(60, speed=0.0))
    recordings.write_source(source / "08_01.npz", recordings.walk(60))
    (source / "09_01.bvh").write_text("nothing")
    return source


def test_the_command_writes_clips_a_catalogue_and_checks(folder, tmp_path, capsys):
    output = tmp_path / "clips"
    listed = tmp_path / "list.csv"
    listed.write_text("clip,description\n07_01,Walk forward\n")
    arguments = ["--input", str(folder), "--output", str(output), "--set", "own", "--licence", "CC0",
                 "--descriptions", str(listed), "--prefix", "x_"]  # fmt: skip
    assert importer.main(arguments) == 0
    told = capsys.readouterr()
    assert "09_01.bvh" in told.err and "| measure | own |" in told.out
    assert (output / "checks.md").read_text().startswith("| measure | own |")
    clips = {clip.name: clip for clip in clip_files.load_clips(output)}
    assert set(clips) == {"x_07_01", "x_07_02", "x_08_01"}
    walk = clips["x_07_01"]
    assert len(walk) == 60 and walk.feet.any() and (walk.labels == "walk").mean() > 0.8
    assert np.abs(np.linalg.norm(walk.rotations, axis=-1) - 1).max() < 1e-9
    with (output / "catalogue.csv").open() as file:
        rows = {row["clip"]: row for row in csv.DictReader(file)}
    assert list(rows["x_07_01"]) == list(catalogue.COLUMNS)
    row = rows["x_07_01"]
    assert (row["action"], row["subject"], row["description"]) == ("walk", "07", "walk forward")
    assert (row["licence"], row["source"], row["frames"]) == ("CC0", "own", "60")


def test_a_clip_has_the_keys_that_the_training_reads(tmp_path):
    motion = recordings.walk(30)
    clip = importer.finished(motion, None, "walk")
    path = catalogue.save(
        catalogue.ImportedClip("a", clip.motion, clip.labels, clip.contact, clip.glitch), tmp_path
    )
    with np.load(path) as data:
        assert set(data) == {"root_pos", "local_quat_wxyz", "label", "label_names", "contact", "glitch",
                             "rest_joints", "parents", "names", "fps", "source_clip"}  # fmt: skip
        assert data["local_quat_wxyz"].shape == (30, 22, 4) and data["contact"].shape == (30, 4)
        assert tuple(data["label_names"]) == labels.LABELS and int(data["fps"]) == 30
        assert np.allclose(data["rest_joints"], recordings.REST, atol=1e-6)
        assert tuple(data["names"]) == skeleton.BODY_JOINTS
    back = clip_files.load_clip(path)
    positions, _ = skeleton.forward_kinematics(back.root, back.rotations, recordings.REST)
    assert np.abs(positions - clip.motion.forward_kinematics()[0]).max() < 1e-3


def test_sits_are_told_with_their_times():
    count = 120
    motion = recordings.walk(count, speed=0.0)
    named = np.array(["idle"] * 30 + ["sit_down"] * 15 + ["sit"] * 45 + ["stand_up"] * 15 + ["idle"] * 15)
    clip = catalogue.ImportedClip("a", motion, named, np.zeros((count, 4), bool), np.zeros(count, bool))
    (event,) = json.loads(catalogue.row(clip, "s", "l")["events"])
    assert (event["down"], event["seat_start"], event["seat_end"], event["up_end"]) == (1.0, 1.5, 2.97, 3.47)
    assert catalogue.main_action(named) == "sit"


@pytest.mark.parametrize(
    "name, subject",
    [("07_01", "07"), ("getup_139_16", "139"), ("Male1_A1_Stand", "Male1"), ("ual_idle", "ual")],
)
def test_whose_a_clip_is(name, subject):
    assert importer.subject_of(name) == subject


def test_what_cannot_be_imported_is_told_in_one_line(tmp_path, capsys):
    output = ["--output", str(tmp_path / "out")]
    assert importer.main(["--input", str(tmp_path / "missing"), *output]) == 1
    assert "does not exist" in capsys.readouterr().err
    (tmp_path / "a.bvh").write_text("nothing")
    assert importer.main(["--input", str(tmp_path / "a.bvh"), *output]) == 1
    assert "No clip could be imported from 1 files" in capsys.readouterr().err.splitlines()[-1]
