"""Ten numbers for the shape of a body, SMPL-X's betas, with the shapes of the default human as their basis."""

from __future__ import annotations

import functools
from collections.abc import Mapping

import numpy as np

from . import human
from .human import Human

COUNT = 10
SHAPES = ("male", "female", "tall", "short", "heavy", "thin", "muscular", "elder")
"""The shapes that the first eight numbers are values of, 0 to 1; the last two are 0."""


def from_shapes(values: np.ndarray) -> np.ndarray:
    """Return betas (..., 10) of values (..., 8) in the order of SHAPES."""
    values = np.asarray(values, dtype=np.float64)
    return np.concatenate([values, np.zeros((*values.shape[:-1], COUNT - len(SHAPES)))], axis=-1)


def from_named(values: Mapping[str, float]) -> np.ndarray:
    """Return betas (10,) of shapes by name."""
    return from_shapes(np.array([values.get(name, 0.0) for name in SHAPES]))


@functools.lru_cache(maxsize=32)
def _body(values: tuple[float, ...]) -> Human:
    named = {name: value for name, value in zip(SHAPES, values, strict=False) if value}
    return human.load().shaped(named) if named else human.load()


def body_of(betas: np.ndarray) -> Human:
    """Return the default human with betas (10,); cached."""
    return _body(tuple(float(value) for value in betas))
