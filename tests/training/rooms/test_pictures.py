"""Pictures by rays: depth, classes and matrices agree with each other; the same seed gives the same picture."""

import numpy as np
import pytest

pytest.importorskip("embreex")

from samp_blender.training.furniture import shapes  # noqa: E402
from samp_blender.training.rooms.classes import CLASS, PERSON  # noqa: E402
from samp_blender.training.rooms.layout.room import Room  # noqa: E402
from samp_blender.training.rooms.pictures import camera, paints, shading, tracer  # noqa: E402

SIZE = (64, 36)


@pytest.fixture(scope="module")
def room():
    """A floor, a wall three metres ahead and a table in front of it."""
    parts = [
        ("floor", shapes.box((-4, -0.1, -4), (4, 0, 4), 1), "floor"),
        ("wall", shapes.box((-4, 0, 3), (4, 3, 3.1), 1), "wall0"),
        ("table", shapes.box((-0.5, 0, 1.5), (0.5, 0.7, 2.0), 1), "table/0"),
    ]  # fmt: skip
    count = [len(t) for _, t, _ in parts]
    return Room(
        "office", (8.0, 8.0, 3.0), np.concatenate([t for _, t, _ in parts]),
        np.repeat([CLASS[n] for n, *_ in parts], count).astype(np.uint8),
        np.repeat([-1, -1, 0], count).astype(np.int16),
        np.repeat([0, 2, 1], count).astype(np.int16), ["floor", "table/0", "wall0"],
        ["table"], ["table"], np.zeros((1, 4)),
    )  # fmt: skip


def drawn(room, seed=0, body=None):
    rng = np.random.default_rng(seed)
    view = camera.looking(np.array([0.0, 1.2, 0.0]), np.array([0.0, 1.2, 3.0]), np.radians(95))
    seen = tracer.Tracer(room)
    return view, shading.picture(
        seen, view, paints.draw(room, rng), paints.light(room, rng), body, rng, SIZE, 1
    )


def test_depth_and_classes_tell_what_is_there(room):
    view, made = drawn(room)
    assert made.colour.shape == (36, 64, 3) and made.colour.dtype == np.uint8 and made.colour.std() > 5
    top = made.depth[8]
    np.testing.assert_allclose(top, 3.0, atol=1e-3)
    assert (made.classes[8] == CLASS["wall"]).all() and (made.classes[-1, :5] == CLASS["floor"]).all()
    assert (made.classes == CLASS["table"]).any()
    np.testing.assert_allclose(made.normal[8], np.broadcast_to([0, 0, -1.0], (64, 3)), atol=1e-4)


def test_matrices_lead_to_pixels_and_back(room):
    view, made = drawn(room)
    row, column = 30, 40
    pixel = np.array([column + 0.5, row + 0.5, 1.0]) * made.depth[row, column]
    local = np.linalg.solve(view.intrinsics(SIZE), pixel)
    world = np.linalg.solve(view.extrinsics(), np.append(local, 1.0))[:3]
    assert abs(world[1]) < 1e-3 or world[1] <= 0.71
    pixels, depth = view.project(world[None], SIZE)
    np.testing.assert_allclose(pixels[0], [column + 0.5, row + 0.5], atol=0.02)
    np.testing.assert_allclose(depth[0], made.depth[row, column], atol=1e-3)
    hit = view.rays(SIZE)[row, column]
    along = (world - view.position) / np.linalg.norm(world - view.position)
    np.testing.assert_allclose(hit, along, atol=1e-4)


def test_a_person_hides_what_is_behind(room):
    box = shapes.box((-0.2, 0, 0.8), (0.2, 1.7, 1.0), 1)
    body = tracer.Body(
        box.reshape(-1, 3), np.arange(len(box) * 3).reshape(-1, 3), np.full(len(box), -2, np.int16)
    )
    _, made = drawn(room, body=body)
    person = made.classes == PERSON
    assert 0.02 < person.mean() < 0.5
    assert made.depth[person].max() < 1.01


def test_the_same_seed_gives_the_same_picture(room):
    first, again, other = (drawn(room, seed)[1].colour for seed in (4, 4, 5))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first.astype(int) - other).mean() > 5
