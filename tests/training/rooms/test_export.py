"""A corpus exported for MotionNet: sits with goals where the pelvis rests and grids around them, walks between."""

import numpy as np
import pytest
from samp_blender.training.furniture import shapes
from samp_blender.training.rooms.corpus import export, store
from samp_blender.training.rooms.episodes import bodies
from samp_blender.training.rooms.episodes.bank import LABELS
from samp_blender.training.rooms.layout.room import Room

INDEX = {name: k for k, name in enumerate(LABELS)}
PLACE = np.array([1.0, 0.0, 2.0, np.pi / 2])


def episode():
    """Labels and items of a walk, a sit on item 0, a walk, and a final rest without standing up."""
    names = ["walk"] * 300 + ["sit_down"] * 20 + ["sit"] * 100 + ["stand_up"] * 20 + ["walk"] * 300
    items = np.full(len(names), -1)
    items[300:440] = 0
    return np.array([INDEX[n] for n in names]), items


def test_an_episode_is_split_into_sits_and_walks():
    labels, items = episode()
    parts = export.stretches(np.array(LABELS)[labels], items)
    assert [p.rest is not None for p in parts] == [False, True, False]
    sit = parts[1]
    assert sit.rest == (320, 419) and sit.item == 0 and sit.first == 300 - export.APPROACH
    assert all(a.stop == b.first for a, b in zip(parts[:-1], parts[1:], strict=True))


@pytest.fixture
def corpus(tmp_path):
    labels, items = episode()
    count = len(labels)
    chair = shapes.box((-0.2, 0.0, -0.3), (0.2, 0.45, 0.2), 4)
    c, s = np.cos(PLACE[3]), np.sin(PLACE[3])
    x, z = chair[..., 0] * c + chair[..., 2] * s, -chair[..., 0] * s + chair[..., 2] * c
    placed = np.stack([x + PLACE[0], chair[..., 1], z + PLACE[2]], -1)
    flags = lambda value: np.full(len(chair), value)
    room = Room("cafe", (6.0, 6.0, 2.5), placed, flags(6).astype(np.uint8), flags(0).astype(np.int16),
                flags(0).astype(np.int16), ["chair/0"], ["chair"], ["chair"], PLACE[None])  # fmt: skip
    folder = store.room_folder(tmp_path, 0)
    (folder / "layout").mkdir(parents=True)
    room.save(folder / "layout" / "room.npz")
    down = np.interp(np.arange(count), [300, 320, 420, 440], [0, 1, 1, 0])
    root = np.column_stack([np.full(count, PLACE[0]), 0.93 - 0.3 * down, PLACE[2] + 0.5 * (1 - down)])
    rotations = np.zeros((count, 22, 4), np.int16)
    rotations[..., 0] = store.QUATERNION
    store.write_stage(folder, "motion", {
        "bounds": np.array([0, count], np.int32), "shapes": np.zeros((1, len(bodies.SHAPES)), np.float32),
        "root": root.astype(np.float32), "rotations": rotations, "labels": labels.astype(np.uint8),
        "contacts": np.zeros((count, 5), np.uint8), "objects": items.astype(np.int16),
    })  # fmt: skip
    store.write_json(tmp_path / "manifest.json", {"rooms": [{"number": 0, "split": "train", "episodes": 1}]})
    return tmp_path


def test_the_goal_is_where_the_pelvis_rests_on_its_piece(corpus, tmp_path):
    target = tmp_path / "motion.npz"
    assert export.main(["--output", str(corpus), "--to", str(target), "--frames", "1000"]) == 0
    with np.load(target) as made:
        kinds, lengths, goal = made["kinds"], made["lengths"], made["goal"]
        assert sorted(kinds) == ["sit", "walk", "walk"] and bool(made["mirrored"])
        number = int(np.flatnonzero(kinds == "sit")[0])
        first = int(lengths[:number].sum())
        rests = goal[first + int(lengths[number]) // 2]
        np.testing.assert_allclose(rests[:3], [PLACE[0], 0.63, PLACE[2]], atol=0.02)
        assert made["goal_action"][first + int(lengths[number]) // 2] == 3
        np.testing.assert_allclose(made["placements"][number], [PLACE[0], PLACE[2], 0.0], atol=0.02)
        assert bool(made["goal_grid"])
        # The body faces +Z from the middle of the grid; the chair, turned by a quarter, reaches 0.3 m to its right.
        centres, occupancy = (
            made[f"piece_{name}"][made["pieces"][number]] for name in ("centres", "occupancy")
        )
        np.testing.assert_allclose(np.ptp(centres, axis=0), np.array([1.4, 1.4, 1.8]) * 7 / 8, atol=1e-5)
        full = centres[occupancy > 0.7]
        assert full[:, 0].min() < -0.25 and full[:, 0].max() < 0.3 and np.abs(full[:, 2]).max() < 0.35
        assert 0.2 < full[:, 1].max() < 0.6 and not occupancy[centres[:, 1] > 0.8].any()


def test_a_body_is_carried_back_to_the_default_human():
    labels, _ = episode()
    count = len(labels)
    root = np.column_stack([np.zeros(count), np.full(count, 0.93), np.zeros(count)])
    rotations = np.zeros((count, 22, 4))
    rotations[..., 0] = 1
    build = bodies.of(np.array([0.5 if s == "tall" else 0.0 for s in bodies.SHAPES]))
    tall = root * [1, build.body.floor / bodies.of(np.zeros(8)).body.floor, 1]
    back, turned = bodies.on_default(tall, rotations, labels, build)
    stands = slice(0, 250)
    np.testing.assert_allclose(back[stands, 1], 0.93, atol=0.005)
    np.testing.assert_allclose(turned[stands], rotations[stands], atol=1e-6)
    seated = slice(350, 400)
    np.testing.assert_allclose(tall[seated, 1] - back[seated, 1], build.seat, atol=0.003)
