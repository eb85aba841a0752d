"""Markers of a known motion on a known body, written as C3D and solved again."""

from __future__ import annotations

import functools
import warnings
from pathlib import Path

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Motion
from samp_blender.training.clips import importer, markers
from samp_blender.training.clips.formats import c3d_file
from samp_blender.training.clips.markers import places, pose
from samp_blender.training.clips.markers.figure import Figure

c3d = pytest.importorskip("c3d", reason="C3D files need the package c3d (requirements.txt)")
NAMES = tuple(name for name in places.places() if name != "SACR")
JOINTS = np.array([places.places()[name][0] for name in NAMES])
SIZE = 1.06


@functools.cache
def body() -> tuple[np.ndarray, np.ndarray]:
    """Rest joints (22, 3) of a taller person, and places of markers up to 1 cm off where they should be."""
    own = np.array([places.places()[name][1] for name in NAMES]) * SIZE
    return recordings.REST * SIZE, own + np.random.default_rng(2).uniform(-0.01, 0.01, own.shape)


def tracks(motion: Motion) -> np.ndarray:
    """The markers (T, M, 3) of a motion, metres, Y up."""
    rest, own = body()
    joints, globals_ = skeleton.forward_kinematics(motion.root * SIZE, motion.rotations, rest)
    return joints[:, JOINTS] + rotation.rotate(
        globals_[:, JOINTS], np.broadcast_to(own, (len(joints), *own.shape))
    )


def write(path: Path, seen: np.ndarray, names=NAMES, fps: float = 30.0, prefix: str = "Walker:") -> Path:
    """A .c3d of markers (T, M, 3), millimetres, Z up; NaN where one is not seen, and one marker without a name."""
    writer = c3d.Writer(point_rate=fps)
    writer.set_point_labels([prefix + name for name in names] + ["*12"])
    turned = np.stack([seen[..., 0], -seen[..., 2], seen[..., 1]], -1) * 1000
    frames = []
    for frame in turned:
        points = np.zeros((len(names) + 1, 5), np.float32)
        points[:-1, :3] = np.nan_to_num(frame)
        points[:-1, 3] = np.where(np.isfinite(frame[:, 0]), 0, -1)
        frames.append((points, np.zeros((0, 0), np.float32)))
    writer.add_frames(frames)
    with warnings.catch_warnings(), path.open("wb") as file:
        warnings.simplefilter("ignore")
        writer.write(file)
    return path


def test_a_file_is_read(tmp_path):
    seen = tracks(recordings.walk(6))
    seen[2, 5] = np.nan
    found = c3d_file.read(write(tmp_path / "a.c3d", seen, fps=120.0))
    assert found.fps == 120.0 and found.names == NAMES
    back = np.stack([found.places[..., 0], found.places[..., 2], -found.places[..., 1]], -1)
    assert np.isnan(back[2, 5]).all()
    assert np.nanmax(np.abs(back - seen)) < 1e-4


def test_poses_come_back_exactly_where_the_body_is_known():
    motion = recordings.walk(12)
    rest, own = body()
    figure = Figure(recordings.OFFSETS * SIZE, JOINTS, own)
    found = pose.posed(tracks(motion), figure)
    joints, _, placed = pose.kinematics(found.root, found.turns, figure)
    wanted, _ = skeleton.forward_kinematics(motion.root * SIZE, motion.rotations, rest)
    away = np.linalg.norm(joints - wanted, axis=-1)
    assert away.mean() < 0.004 and away.max() < 0.025
    assert found.error.max() < 0.008


def test_an_unknown_body_is_found_with_its_motion(tmp_path):
    """One marker in thirty is not seen; noise of 1 mm. Joints to 2 cm, thigh and shin to 1 cm."""
    motion = recordings.walk(40)
    rng = np.random.default_rng(0)
    seen = tracks(motion) + rng.normal(0, 0.001, (40, len(NAMES), 3))
    seen[rng.random(seen.shape[:2]) < 1 / 30] = np.nan
    (found,) = markers.solved([write(tmp_path / "a.c3d", seen)])
    rest, _ = body()
    wanted, _ = skeleton.forward_kinematics(motion.root * SIZE, motion.rotations, rest)
    assert np.linalg.norm(found.positions - wanted, axis=-1).mean() < 0.02
    for a, b in ((1, 4), (4, 7)):
        length = np.linalg.norm(found.rest[b] - found.rest[a])
        assert length == pytest.approx(np.linalg.norm(rest[b] - rest[a]), abs=0.01)
    (clip,) = importer.imported([found], "a")
    knees = clip.motion.forward_kinematics()[0]
    assert np.abs(clip.motion.root[:, 1] - motion.root[:, 1]).mean() < 0.03
    assert np.isfinite(knees).all()


def test_too_few_markers_are_told(tmp_path):
    seen = tracks(recordings.walk(30))[:, :10]
    with pytest.raises(SampError, match="known markers"):
        markers.solved([write(tmp_path / "a.c3d", seen, NAMES[:10])])
    (tmp_path / "b.c3d").write_text("nothing")
    with pytest.raises(SampError, match="not a readable C3D"):
        markers.solved([tmp_path / "b.c3d"])
