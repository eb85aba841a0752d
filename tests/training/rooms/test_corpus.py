"""The corpus on disk: room_builder are whole or not there, motion is read back, windows keep what they promise."""

import numpy as np
import pytest
from samp_blender.training.rooms.corpus import store, windows

UNIT = store.QUATERNION


def motion(frames=200, speed=0.5):
    """Arrays of one episode of a body that glides along Z at a speed in m/s."""
    rotations = np.zeros((frames, 22, 4), np.int16)
    rotations[..., 0] = UNIT
    root = np.zeros((frames, 3), np.float32)
    root[:, 1], root[:, 2] = 0.93, np.arange(frames) / 30 * speed
    return {
        "bounds": np.array([0, frames], np.int32), "shapes": np.zeros((1, 8), np.float32), "root": root,
        "rotations": rotations, "labels": np.zeros(frames, np.uint8), "contacts": np.zeros((frames, 5), np.uint8),
    }  # fmt: skip


def test_a_stage_is_whole_or_not_there(tmp_path):
    with pytest.raises(TypeError):
        store.write_stage(tmp_path, "motion", {"a": np.arange(3)}, {"bad": object()})
    assert not store.has_stage(tmp_path, "motion")
    store.write_stage(tmp_path, "motion", {"a": np.arange(3)}, {"n": 1})
    store.write_stage(tmp_path, "motion", {"a": np.arange(4)}, {"n": 2})
    assert store.has_stage(tmp_path, "motion") and store.notes(tmp_path, "motion") == {"n": 2}
    assert len(np.load(tmp_path / "motion" / "a.npy", mmap_mode="r")) == 4


def test_motion_is_read_back(tmp_path):
    store.write_stage(tmp_path, "motion", motion())
    read = store.RoomData(tmp_path).motion(0, 10, 20)
    assert read.root.shape == (20, 3) and read.rotations.shape == (20, 22, 4)
    np.testing.assert_allclose(read.root[0, 2], 10 / 30 * 0.5, atol=1e-6)
    np.testing.assert_allclose(read.rotations[..., 0], 1.0)


@pytest.mark.parametrize("speed, some", [(0.2, False), (0.5, True)])
def test_windows_go_somewhere(tmp_path, speed, some):
    folder = store.room_folder(tmp_path, 0)
    store.write_stage(folder, "motion", motion(speed=speed))
    store.write_stage(
        folder, "pictures", {"episode": np.zeros(2, np.int32), "frame": np.array([3, 9], np.int32)}
    )
    counts = windows.write(tmp_path, [{"number": 0, "split": "train"}], 0)
    rows = np.load(tmp_path / "windows_train.npy")
    assert (len(rows) > 0) is some and counts["windows_train"] == len(rows)
    for _, episode, first in rows:
        part = store.RoomData(folder).motion(episode, first, windows.LENGTH)
        assert len(part) == windows.LENGTH
        assert np.linalg.norm(part.root[-1] - part.root[0]) >= windows.APART
    assert np.load(tmp_path / "bodies_train.npy").shape == (20, 3)
    np.testing.assert_array_equal(np.load(tmp_path / "pictures_train.npy"), [[0, 0, 0, 3], [0, 1, 0, 9]])
    assert counts["windows_test"] == 0


def test_a_crop_is_seen_from_the_body():
    points = np.array([[1.0, 0.4, 2.5], [3.0, 0.0, 0.0], [1.0, 1.0, 2.0]])
    rows, local = windows.crop(points, np.array([1.0, 0.93, 2.0]), np.pi / 2)
    assert rows.tolist() == [0, 2]
    # Facing +X, what is towards +Z is on the right.
    np.testing.assert_allclose(local, [[-0.5, 0.4, 0.0], [0.0, 1.0, 0.0]], atol=1e-9)
