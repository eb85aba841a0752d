"""Bodies by height, weight, muscle, age and gender."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.blender.character import measures
from samp_blender.samp_addon.body import betas, body_shape, human
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.methods.long_term import synthesis
from samp_blender.training.rooms.episodes import bodies


@pytest.mark.parametrize(
    "wanted",
    [
        {"height": 1.50},
        {"height": 1.55, "weight": 45, "gender": 0},
        {"height": 1.55, "weight": 65},
        {"height": 1.68, "age": 80},
        {"height": 1.75, "weight": 90, "muscle": 1},
        {"height": 1.95, "weight": 80, "gender": 1},
        {"height": 1.95, "weight": 115, "gender": 1},
        {"height": 2.00, "gender": 0.2},
        {"weight": 70},
    ],
)
def test_a_body_has_the_measures_that_were_asked_for(wanted):
    made = human.load().shaped(body_shape.shapes(wanted))
    assert made.height == pytest.approx(wanted.get("height", made.height), abs=0.01)
    weight = body_shape.weight_of(made)
    assert weight == pytest.approx(wanted.get("weight", weight), abs=0.1)
    # Joints follow: ankles are over the soles, and shoulders below the top of the head.
    assert 0.04 < made.joints[7, 1] - made.floor < 0.12
    assert 0.75 < (made.joints[16, 1] - made.floor) / made.height < 0.9


def test_no_measures_are_the_default_human():
    assert body_shape.shapes({}) == {}
    assert body_shape.shapes({"muscle": 0, "age": 25, "gender": 0.5}) == {}


def test_figures_differ():
    figures = [human.load().shaped(body_shape.shapes({"height": 1.7, "gender": g})) for g in (0, 1)]
    assert np.abs(figures[0].vertices - figures[1].vertices).max() > 0.02


@pytest.mark.parametrize(
    "values, words",
    [
        ({"height": 2.4}, "Height is 2.4 m; choose from 1.5 to 2 m"),
        ({"age": 7}, "Age is 7 years"),
        ({"height": 1.95, "weight": 45}, "Weight is 45 kg; choose from .* for this height, age and gender"),
        ({"girth": 1}, "--shape has no 'girth'; use height, weight, muscle, age, gender"),
    ],
)
def test_bodies_that_cannot_be(values, words):
    with pytest.raises(UsageError, match=words):
        body_shape.check(values)


@pytest.mark.parametrize(
    "text, found",
    [("height=1.85", ("height", 1.85)), ("gender=male", ("gender", 1.0)), ("age=40", ("age", 40.0))],
)
def test_measures_are_read(text, found):
    assert body_shape.measure(text) == found


@pytest.mark.parametrize("text", ["height", "height=", "=1.8", "height=nan", "muscle=strong"])
def test_texts_that_are_no_measures(text):
    with pytest.raises(UsageError, match="--shape"):
        body_shape.check(dict([body_shape.measure(text)]))


def test_long_term_makes_bodies_that_it_has_learnt():
    assert synthesis.LEARNT == bodies.MOST
    wanted = betas.from_named({"tall": 0.8, "heavy": 0.2})
    expected = betas.from_named({"tall": bodies.MOST["tall"], "heavy": 0.2})
    np.testing.assert_allclose(synthesis.known_betas(wanted), expected)
    assert not synthesis.known_betas(None).any()


def test_the_sliders_have_the_bounds_of_the_measures():
    assert list(measures.LIMITS) == list(body_shape.MEASURES)
    for name, measure in body_shape.MEASURES.items():
        assert measures.LIMITS[name] == (measure.low, measure.high)
        assert measures.USUAL.get(name) == measure.usual
    assert pytest.approx(human.load().height, abs=0.01) == measures.HEIGHT
