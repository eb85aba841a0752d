"""A seated body at a sub-goal, fitted to its seat."""

import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.body import figures, human
from samp_blender.samp_addon.methods.long_term.figure import Figure, as_motion
from samp_blender.samp_addon.methods.long_term.sub_goals import settling
from samp_blender.samp_addon.methods.long_term.surfaces import Surfaces
from samp_blender.samp_addon.scene.navmesh import navmesh

SEAT = 0.45


@pytest.fixture(scope="module")
def field():
    boxes = [
        ((-3, -0.1, -3), (3, 0, 3)),
        ((-0.3, 0.05, -0.3), (0.3, SEAT, 0.25)),
        ((-0.3, SEAT, -0.3), (0.3, 1, -0.2)),
    ]
    triangles = np.concatenate([rooms.box(*box) for box in boxes])
    return Surfaces(triangles, navmesh.build(triangles)).field


def seated(ahead: float, up: float) -> Figure:
    """A body on the seat, moved from where it would rest."""
    pose = figures.figure("sit", SEAT + 0.1)
    return Figure(np.array([0.0, SEAT + 0.1 + up, ahead]), pose.rotations[0, :22], np.zeros(24), np.zeros(10))


def gaps(figure: Figure, field) -> np.ndarray:
    """Signed distances of the skin from floor and seat, metres."""
    body = human.load()
    points = human.skin(body, as_motion([figure]), body.collision)[0].astype(float)
    return np.minimum(field.at(points)[0], points[:, 1])


@pytest.mark.parametrize(("ahead", "up"), [(0.0, -0.06), (-0.12, 0.0), (0.05, 0.08)])
def test_it_is_neither_in_its_seat_nor_over_it(field, ahead, up):
    drawn = seated(ahead, up)
    made = settling.fitted(drawn, field, 0.0, "sit", 4)
    before, after = gaps(drawn, field).min(), gaps(made, field).min()
    assert after > min(before, -0.015) and after > -0.025
    near = np.linalg.norm((made.root - drawn.root)[[0, 2]])
    assert near < 0.2 and settling.fits([made], field, 0.0)[0, 0] < settling.fits([drawn], field, 0.0)[0, 0]
    again = settling.fitted(drawn, field, 0.0, "sit", 4)
    assert again.root.tolist() == made.root.tolist() and np.array_equal(again.rotations, made.rotations)


def test_changes_turn_what_they_say(field):
    drawn = seated(0.0, 0.0)
    still, lean, knees = settling.changed(
        drawn, np.array([[0, 0, 0, 0, 0], [0, 0, 0.3, 0, 0], [0, 0, 0, 0, 0.3]], float), "sit"
    )
    np.testing.assert_allclose(still.joints, drawn.joints, atol=1e-9)
    neck, knee, ankle = 12, 4, 7
    assert lean.joints[neck, 2] < drawn.joints[neck, 2] - 0.1
    np.testing.assert_allclose(lean.joints[knee], drawn.joints[knee], atol=0.05)
    assert knees.joints[ankle, 2] < drawn.joints[ankle, 2] - 0.05


def test_it_does_not_sink_through_a_thin_blanket():
    boxes = [
        ((-3, -0.1, -3), (3, 0, 3)),
        ((-0.5, 0.05, -0.3), (0.5, SEAT - 0.04, 0.25)),
        ((-0.5, SEAT - 0.01, -0.3), (0.5, SEAT, 0.25)),
    ]
    triangles = np.concatenate([rooms.box(*box) for box in boxes])
    field = Surfaces(triangles, navmesh.build(triangles)).field
    figures, costs = settling.settled([seated(0.0, up) for up in (0.02, 0.05, 0.08)], field, 0.0)
    heights = np.array([figure.root[1] for figure in figures])
    skin = human.skin(human.load(), as_motion(figures))
    beside = np.linalg.norm(
        (skin - np.array([figure.root for figure in figures])[:, None])[..., [0, 2]], axis=-1
    )
    assert np.ptp(heights) < 0.011 and np.ptp(costs) < 0.01
    assert skin[..., 1][beside < 0.1].min() > SEAT - 0.025
