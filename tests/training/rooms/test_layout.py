"""Furnished rooms: nothing overlaps, every surface has its class, the same seed gives the same room."""

from pathlib import Path

import numpy as np
import pytest
from samp_blender.training.furniture import library
from samp_blender.training.furniture.library import is_held_out
from samp_blender.training.rooms.classes import CLASS, CLASSES
from samp_blender.training.rooms.corpus.room_builder import POINTS, cloud
from samp_blender.training.rooms.layout import floorplan, kinds, room, shell, stock

NOWHERE = Path("nowhere")


@pytest.fixture(scope="module")
def pieces():
    few = dict.fromkeys(stock.PROCEDURAL, 3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stock, "PROCEDURAL", {**few, "table": 14})
        yield stock.build(NOWHERE)


@pytest.mark.parametrize("kind", list(kinds.KINDS))
def test_a_room_is_furnished_without_overlaps(kind, pieces):
    made = room.furnish(kind, pieces, np.random.default_rng(5))
    width, depth, height = made.size
    assert 12 <= width * depth <= 40 and len(made.seats) > 0
    assert set(np.unique(made.classes)) <= set(range(len(CLASSES)))
    assert {CLASS[n] for n in ("floor", "wall", "ceiling", "door")} <= set(made.classes)
    assert len(made.triangles) == len(made.classes) == len(made.objects) == len(made.paints)
    furniture = made.triangles[made.objects >= 0]
    assert (np.abs(furniture[..., 0]) < width / 2 + 0.01).all() and (
        np.abs(furniture[..., 2]) < depth / 2 + 0.01
    ).all()
    assert furniture[..., 1].min() > -0.01 and furniture[..., 1].max() < height
    prints = []
    for number in made.seats:
        corners = made.triangles[made.objects == number].reshape(-1, 3)[:, [0, 2]]
        prints.append((corners.min(0), corners.max(0), made.places[number]))
    for k, (low, high, place) in enumerate(prints):
        for other_low, other_high, other in prints[:k]:
            # Axis-aligned boxes of pieces that are not turned tell overlaps exactly.
            if np.isclose(np.sin(2 * np.array([place[3], other[3]])), 0, atol=1e-6).all():
                assert (np.minimum(high, other_high) - np.maximum(low, other_low)).min() < 0.005


def test_the_same_seed_gives_the_same_room(pieces):
    first, again, other = (room.furnish("office", pieces, np.random.default_rng(seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.triangles, again.triangles)
    assert first.names == again.names and first.size != other.size


def test_a_saved_room_is_read_back(tmp_path, pieces):
    made = room.furnish("cafe", pieces, np.random.default_rng(3))
    made.save(tmp_path / "room.npz")
    back = room.Room.load(tmp_path / "room.npz")
    np.testing.assert_allclose(back.triangles, made.triangles, atol=1e-6)
    assert (back.kind, back.names, back.seats) == (made.kind, made.names, made.seats)


@pytest.mark.parametrize(
    "centre, yaw, overlaps",
    [
        ((0.9, 0.0), 0.0, True),
        ((1.1, 0.0), 0.0, False),
        ((1.1, 0.0), np.pi / 4, True),
        ((1.3, 0.0), np.pi / 4, False),
    ],
)
def test_rectangles_overlap(centre, yaw, overlaps):
    half = np.array([0.5, 0.5])
    square = floorplan.Rectangle(np.zeros(2), half, 0.0)
    assert square.overlaps(floorplan.Rectangle(np.array(centre), half, yaw)) is overlaps


def test_openings_keep_apart_and_walls_stay_closed_around_them():
    built = shell.build((4.0, 5.0, 2.5), (2, 3), np.random.default_rng(0))
    assert any(o.kind == "door" for o in built.openings)
    for k, o in enumerate(built.openings):
        assert abs(o.at) + o.size[0] / 2 < shell.wall_frame(built.size, o.wall)[2] / 2
        assert all(
            p.wall != o.wall or abs(p.at - o.at) > (p.size[0] + o.size[0]) / 2 for p in built.openings[:k]
        )


def test_a_cloud_shows_the_inside(pieces):
    made = room.furnish("bedroom", pieces, np.random.default_rng(2))
    points = cloud(made, 0)
    assert points["points"].shape == (POINTS, 3) and len(points["classes"]) == POINTS
    walls = points["classes"] == CLASS["wall"]
    inwards = -(points["points"][walls] * points["normals"][walls] * [1, 0, 1]).sum(-1)
    assert (inwards > 0).mean() > 0.95
    assert {"floor", "wall", "bed"} <= {CLASSES[k] for k in np.unique(points["classes"])}


def test_test_rooms_get_held_out_pieces_only():
    if not (stock.DEFAULT_FOLDER / "manifest.csv").exists():
        pytest.skip("the furniture library is not beside the checkout")
    items = stock.build(stock.DEFAULT_FOLDER, test=True).named()
    assert items and all(is_held_out(name) for name in items)
    # The split is one of the library's pieces; procedural ones are made for training.
    kept = {piece.name for piece in library.load(stock.DEFAULT_FOLDER, held_out=True)}
    assert kept and not kept & set(stock.build(stock.DEFAULT_FOLDER).named())
