"""Refining never makes a take worse."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.methods.take import Take
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline.refine_takes import refine_take
from samp_blender.samp_addon.refine.refinement import Refined, Surroundings


def measures(success, depth):
    return {"success": success, "penetration_max_cm": depth}


@pytest.mark.parametrize(
    ("before", "after", "unsolved", "kept"),
    [
        (measures(True, 6.0), measures(True, 1.0), 0.01, False),
        (measures(True, 6.0), measures(True, 7.0), 0.07, False),
        (measures(False, 6.0), measures(False, 1.0), 0.01, False),
        (measures(True, 3.0), measures(False, 0.0), 0.0, True),
        (measures(True, 3.0), measures(True, 9.0), 0.09, True),
    ],
    ids=["better", "as deep", "never on its goal", "off its goal", "deeper"],
)
def test_a_worse_result_is_not_taken(before, after, unsolved, kept):
    motion = Motion(np.zeros((3, 3)), np.tile([1.0, 0, 0, 0], (3, 22, 1)), 30.0)
    other = Motion(np.ones((3, 3)), motion.rotations, 30.0)
    result = Refined(other, before, after, unsolved)
    surroundings = Surroundings(np.zeros((0, 3, 3)), np.zeros(0))
    take, failure = refine_take(
        Take(0, motion), surroundings, human.load(), lambda *_: result, lambda stage, share: None
    )
    assert failure is None
    assert take.motion.root[0, 0] == pytest.approx(0.0 if kept else 1.0)
    assert take.refined.after == (before if kept else after)
    assert any("as before refining" in note for note in take.refined.notes) == kept
