"""AMASS .npz files: the conventions of SMPL-X tools, and a lossless round trip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon import frames, rotation
from samp_blender.samp_addon.body import amass
from samp_blender.samp_addon.errors import SampError
from samp_blender.tests.support.blender import rigs


@pytest.mark.parametrize("joints", [22, 55])
def test_round_trip(tmp_path, joints):
    rng = np.random.default_rng(3)
    take = rigs.take(
        20, joints, contacts=rng.random((20, 5)), actions=rng.random((20, 5)), interaction_start=7
    )
    path = amass.write_amass(take, tmp_path / "deeper" / "take")
    assert path.name == "take.npz"
    again = amass.read_amass(path)
    assert again.fps == 30 and again.interaction_start == 7 and again.rotations.shape == (20, 55, 4)
    assert np.abs(again.root - take.root).max() < 1e-6
    assert np.abs(np.sum(again.rotations[:, :joints] * take.rotations, axis=-1)).min() > 1 - 1e-6
    assert np.abs(again.contacts - take.contacts).max() < 1e-6


def test_keys_and_convention(tmp_path):
    """Z-up; the pelvis of SMPL-X's forward pass (rest pelvis + trans) is the pelvis of the take."""
    take = rigs.take(10)
    with np.load(amass.write_amass(take, tmp_path / "take.npz")) as data:
        assert str(data["gender"]) == "neutral" and str(data["surface_model_type"]) == "smplx"
        assert (
            data["poses"].shape == (10, 165)
            and data["trans"].shape == (10, 3)
            and data["betas"].shape == (16,)
        )
        assert float(data["mocap_frame_rate"]) == 30 and int(data["num_betas"]) == 16
        parts = ("root_orient", "pose_body", "pose_jaw", "pose_eye", "pose_hand")
        assert np.array_equal(np.concatenate([data[part] for part in parts], axis=1), data["poses"])
        assert np.abs(amass.REST_PELVIS + data["trans"] - frames.to_blender(take.root)).max() < 1e-6
        # The up axis of a standing SMPL-X body is Y; in the file's world the take's is where Blender shows
        # it.
        turned = rotation.rotate(rotation.from_axis_angle(data["root_orient"]), np.array([0.0, 1.0, 0.0]))
        ours = rotation.rotate(take.rotations[:, 0], np.array([0.0, 1.0, 0.0]))
        assert np.abs(turned - frames.to_blender(ours)).max() < 1e-6


def older_file(path, **changes):
    content = {
        "poses": np.zeros((5, 156)),
        "trans": np.zeros((5, 3)),
        "mocap_framerate": np.array(120.0),
    } | changes
    np.savez(path, **{key: value for key, value in content.items() if value is not None})


def test_reads_files_of_smpl_h(tmp_path):
    older_file(tmp_path / "a.npz")
    take = amass.read_amass(tmp_path / "a.npz")
    assert take.fps == 120 and take.rotations.shape == (5, 22, 4)
    assert np.allclose(frames.to_blender(take.root), amass.REST_PELVIS)


@pytest.mark.parametrize(
    "changes",
    [
        {"poses": None},
        {"trans": None},
        {"mocap_framerate": None},
        {"poses": np.zeros((5, 30))},
        {"trans": np.zeros((4, 3))},
    ],
)
def test_other_npz_files_are_refused(tmp_path, changes):
    older_file(tmp_path / "a.npz", **changes)
    with pytest.raises(SampError, match="not an AMASS motion"):
        amass.read_amass(tmp_path / "a.npz")


def test_other_files_are_refused(tmp_path):
    with pytest.raises(SampError, match="no file"):
        amass.read_amass(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(SampError, match="not an .npz file"):
        amass.read_amass(tmp_path / "text.npz")
    with pytest.raises(SampError):
        amass.read_amass(tmp_path)


def test_broken_takes_and_places_are_refused(tmp_path):
    take = rigs.take(5)
    with pytest.raises(SampError, match="not numbers"):
        amass.write_amass(replace(take, root=take.root * np.nan), tmp_path / "a.npz")
    (tmp_path / "file").write_text("")
    with pytest.raises(SampError, match="cannot be written"):
        amass.write_amass(take, tmp_path / "file" / "a.npz")


def test_published_files_are_read_without_pickle(tmp_path):
    count = 4
    content = {
        "root_orient": np.zeros((count, 3)),
        "pose_body": np.zeros((count, 63)),
        "trans": np.zeros((count, 3)),
        "mocap_frame_rate": np.array(120.0),
        "gender": np.array("neutral"),
        "latent_labels": np.array(["ARIEL", "C7"]),
        "markers_latent_vids": np.array({"ARIEL": 3829}, dtype=object),
    }
    np.savez(tmp_path / "walk_stageii.npz", **content)
    assert len(amass.read_amass(tmp_path / "walk_stageii.npz")) == count
    np.savez(tmp_path / "poses.npz", **(content | {"pose_body": np.array({"a": 1}, dtype=object)}))
    with pytest.raises(SampError):
        amass.read_amass(tmp_path / "poses.npz")
