"""A body that hovers over a mattress while it lies down is lowered onto it."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon.methods.samp.finishing.hovering import ENOUGH, lowered
from samp_blender.samp_addon.methods.samp.finishing.resting import RestingTop
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.geometry import sample_surface
from samp_blender.samp_addon.scene.seats.postures import BED_TO_PELVIS, SEAT_TO_PELVIS
from samp_blender.tests.support.layouts import box

BED = box((-0.8, 0.0, -1.0), (0.8, 0.5, 1.0))
GOAL = Goal(np.array([0.0, 0.5 + BED_TO_PELVIS, 0.0]), np.array([0.0, 0.0, 1.0]), "lie")
STANDS, SITS, LIES = 30, 60, 60


def lies(hover, floor=0.0):
    """Return a body that steps back onto the bed's edge, sits upright above it by ``hover``, then lies on its goal."""
    total = STANDS + SITS + LIES
    height = np.full(total, 0.95)
    sitting = 0.5 + SEAT_TO_PELVIS + hover
    height[STANDS:] = np.interp(
        np.arange(SITS + LIES), [0, 15, SITS, SITS + 30], [0.95, sitting, sitting, GOAL.position[1]]
    )
    away = np.interp(np.arange(total), [0, STANDS, STANDS + SITS, total - 20], [1.6, 0.9, 0.7, 0.0])
    quats = np.zeros((total, 22, 4))
    quats[..., 0] = 1
    lean = np.interp(np.arange(total), [STANDS + SITS, STANDS + SITS + 30], [0.0, np.pi / 2])
    quats[:, 0] = np.stack([np.cos(lean / 2), -np.sin(lean / 2), 0 * lean, 0 * lean], -1)
    root = np.stack([away, height + floor, np.zeros(total)], -1)
    return Motion(root, quats, interaction_start=STANDS)


@pytest.fixture(scope="module")
def top():
    return RestingTop.of(sample_surface(BED, 60_000, seed=0)[0], GOAL, 0.0)


@pytest.mark.parametrize("hover", [0.06, 0.12])
def test_a_hovering_body_is_lowered(top, hover):
    before = lies(hover)
    after = lowered(before, top)
    sits = slice(STANDS + 45, STANDS + SITS)  # over the mattress, still upright
    assert np.abs(after.root[sits, 1] - 0.5 - SEAT_TO_PELVIS).max() < ENOUGH + 0.005
    assert np.allclose(after.root[: STANDS - 15], before.root[: STANDS - 15], atol=1e-3)
    assert np.allclose(after.root[-5:], before.root[-5:], atol=ENOUGH)
    assert np.array_equal(after.root[:, [0, 2]], before.root[:, [0, 2]])
    assert np.abs(np.diff(after.root[:, 1])).max() < 0.05, "without a jump"


@pytest.mark.parametrize(
    ("motion", "most"),
    [(lies(0.0), 0.03), (replace(lies(0.1), interaction_start=None), 0.0)],
    ids=["on the mattress", "no rest"],
)
def test_others_stay_nearly_as_they_are(top, motion, most):
    assert np.abs(lowered(motion, top).root - motion.root).max() <= most
