"""Phases of a take at other speeds: lengths, what stays, feet that stand where they stood."""

from dataclasses import replace

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon.edits import retiming
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.evaluation import feet
from samp_blender.samp_addon.motion import Motion


def sit(walk=90, down=30, rest=60):
    """Return a walk and, as far as the pelvis goes, a sit: it sinks for a second and stays."""
    way = recordings.walk(walk)
    height = np.concatenate([np.linspace(way.root[-1, 1], 0.5, down), np.full(rest, 0.5)])
    root = np.concatenate([way.root, np.column_stack([np.repeat(way.root[-1:, :1], down + rest), height,
                                                      np.repeat(way.root[-1:, 2:], down + rest)])])  # fmt: skip
    rotations = np.concatenate([way.rotations, np.repeat(way.rotations[-1:], down + rest, 0)])
    return Motion(root, rotations, interaction_start=walk)


def test_phases_of_a_sit_and_of_a_walk():
    starts = retiming.phase_starts(sit())
    assert list(starts) == ["walk", "settle", "hold"] and starts["settle"] == 90
    assert 118 <= starts["hold"] <= 122
    assert retiming.phase_starts(recordings.walk(60)) == {"walk": 0}
    assert list(retiming.phase_starts(replace(sit(), interaction_start=0))) == ["settle", "hold"]


@pytest.mark.parametrize(
    "factors, seconds",
    [
        ({"walk": 0.5}, 3 / 0.5 + 1 + 2),
        ({"walk": 1.4}, 3 / 1.4 + 1 + 2),
        ({"settle": 0.7}, 3 + 1 / 0.7 + 2),
        ({"hold": 2.0}, 3 + 1 + 1),
        ({"walk": 1.4, "settle": 0.7, "hold": 0.5}, 3 / 1.4 + 1 / 0.7 + 4),
    ],
)
def test_lengths(factors, seconds):
    motion = sit()
    made = retiming.retimed(motion, factors)
    assert made.motion.seconds == pytest.approx(seconds, abs=0.25)
    assert (np.diff(made.frames) > 0).all() and made.frames[0] == 0 and made.frames[-1] == len(motion) - 1
    for end in (0, -1):
        np.testing.assert_allclose(made.motion.root[end], motion.root[end], atol=0.02)
    shown = made.frames[made.motion.interaction_start]
    assert abs(shown - motion.interaction_start) < 2


def test_the_same_speed_changes_nothing():
    motion = sit()
    assert retiming.retimed(motion, {"walk": 1.0}).motion is motion


@pytest.mark.parametrize("factor", [0.7, 1.4])
def test_feet_slide_no_more_than_before(factor):
    motion = recordings.walk(150)
    before, after = (
        feet.measures(m, 0.0)["stance_slide_cm_s"]
        for m in (motion, retiming.retimed(motion, {"walk": factor}).motion)
    )
    assert after <= max(1.2 * before, 0.5)


@pytest.mark.parametrize(
    "factors, message",
    [({"run": 1.0}, "no phase 'run'"), ({"walk": 9.0}, "'walk' is 9; choose from 0.25 to 4")],
)
def test_impossible_factors(factors, message):
    with pytest.raises(UsageError, match=message):
        retiming.retimed(sit(), factors)
