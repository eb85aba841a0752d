"""Intervals over pieces, the kept third of the held-out pieces, and when the judge fails."""

import math

import numpy as np
import pytest
from samp_blender.benchmarks import judge
from samp_blender.training.evaluation.tables import Estimate
from samp_blender.training.furniture import library


def test_takes_on_one_piece_are_one_unit():
    """Four pieces with five equal takes each: as uncertain as four takes, not as twenty."""
    values = np.repeat([1.0, 2.0, 3.0, 4.0], 5)
    pieces = np.repeat(["a", "b", "c", "d"], 5)
    by_take, by_piece = Estimate.of(list(values)), Estimate.of(list(values), list(pieces))
    assert by_piece.mean == by_take.mean == 2.5
    assert by_piece.half > 1.6 * by_take.half
    assert by_piece.half == pytest.approx(1.96 * np.std([1, 2, 3, 4]) / 2, rel=0.15)
    assert math.isnan(Estimate.of([1.0, 2.0], ["a", "a"]).half)


def test_a_third_of_the_held_out_pieces_is_kept():
    names = [f"piece_{k}" for k in range(3000)]
    held = [name for name in names if library.is_held_out(name)]
    assert all((library.part_of(name) == "training") != library.is_held_out(name) for name in names)
    final = sum(library.part_of(name) == "final" for name in held)
    assert final / len(held) == pytest.approx(1 / 3, abs=0.06)
    one, other = list(library.SIBLINGS)[:2]
    assert library.part_of(one) == library.part_of(other)


GOOD = {
    "status": 0, "crossed": [], "position_error_cm": 3.0, "rotation_error_deg": 2.0, "warnings": [],
}  # fmt: skip


@pytest.mark.parametrize(
    ("fault", "passes"),
    [
        ({}, True),
        ({"status": 1}, False),
        ({"crossed": ["Table"]}, False),
        ({"position_error_cm": 45.0}, False),
        ({"warnings": ["The body squats in the air for 2.8 s."]}, False),
    ],
)
def test_the_judge_fails_where_takes_are_bad(fault, passes):
    assert judge.passes([GOOD, GOOD | fault, GOOD]) is passes


def test_no_room_is_no_success():
    assert not judge.passes([])
