"""Height, weight, muscle, age and gender of the default human, as values of its shapes.

Tall and short, and beyond them the size of the whole body, follow from the height; heavy and thin from the weight, also
beyond 1. Weight is that of the volume of the dressed body.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from . import human
from .human import SIZE, Human

DENSITY = 985.0
"""Kilogrammes of a cubic metre of a living body."""
YOUNG, OLD = 30.0, 80.0
"""Years up to which the shape of an elderly body has no weight, and from which it has all of it."""
MOST_HEAVY, MOST_THIN = 6.0, 2.0
"""Largest values of the shapes heavy and thin that still look like a body."""
STEPS = 30
"""Halvings of the range of heavy or thin."""
WORDS = {"female": 0.0, "neutral": 0.5, "male": 1.0}
"""Genders by name."""


@dataclass(frozen=True)
class Measure:
    """A measure of a body. unit: for messages, with a space before it; low, high: bounds; usual: where it is left out,
    None where that follows from the others."""

    unit: str
    low: float
    high: float
    usual: float | None


MEASURES: dict[str, Measure] = {
    "height": Measure(" m", 1.5, 2.0, None),
    "weight": Measure(" kg", 35.0, 160.0, None),
    "muscle": Measure("", 0.0, 1.0, 0.0),
    "age": Measure(" years", 18.0, 100.0, YOUNG),
    "gender": Measure("", 0.0, 1.0, 0.5),
}


def measure(text: str) -> tuple[str, float]:
    """Return name and value of a text such as "height=1.85" or "gender=male". Raise UsageError."""
    name, sign, value = text.partition("=")
    if sign and name == "gender" and value in WORDS:
        return name, WORDS[value]
    try:
        number = float(value)
    except ValueError:
        number = float("nan")
    if not sign or not np.isfinite(number):
        raise UsageError(f"--shape cannot be '{text[:40]}'; write NAME=VALUE, such as height=1.85.")
    return name, number


def check(values: Mapping[str, float]) -> None:
    """Raise UsageError for measures that no body has."""
    for name, value in values.items():
        if name not in MEASURES:
            raise UsageError(f"--shape has no '{name}'; use {', '.join(MEASURES)}.")
        measure = MEASURES[name]
        if not measure.low <= value <= measure.high:
            raise UsageError(
                f"{name.capitalize()} is {value:g}{measure.unit}; choose from {measure.low:g} to "
                f"{measure.high:g}{measure.unit}."
            )
    shapes(values)


def shapes(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values of the default human's shapes for measures by name, empty for none.

    Raise UsageError for a weight that no body of this height has.
    """
    return dict(_shapes(tuple(sorted((name, float(value)) for name, value in values.items()))))


@functools.lru_cache(maxsize=64)
def _shapes(values: tuple[tuple[str, float], ...]) -> tuple[tuple[str, float], ...]:
    given = dict(values)
    own = lambda name: given.get(name, MEASURES[name].usual)
    gender = 2 * own("gender") - 1
    made = {
        "male": max(gender, 0.0),
        "female": max(-gender, 0.0),
        "muscular": own("muscle"),
        "elder": float(np.clip((own("age") - YOUNG) / (OLD - YOUNG), 0, 1)),
    }
    if "height" in given:
        made |= _tall_or_short(made, given["height"])
    if "weight" in given:
        made |= _heavy_or_thin(made, given["weight"])
    return tuple((name, value) for name, value in made.items() if value)


def _height(values: Mapping[str, float]) -> float:
    return human.load().shaped(values).height


def _tall_or_short(made: Mapping[str, float], height: float) -> dict[str, float]:
    """Return the values of tall or short, and of the size, with which a body is as high as wanted, metres."""
    usual = _height(made)
    name = "tall" if height > usual else "short"
    most = _height({**made, name: 1.0})
    if abs(height - usual) > abs(most - usual):
        return {name: 1.0, SIZE: height / most - 1}
    return {name: (height - usual) / (most - usual)}


def _heavy_or_thin(made: Mapping[str, float], weight: float) -> dict[str, float]:
    """Return the value of heavy or thin with which a body has a weight, kilogrammes. Raise UsageError."""
    usual = weight_of(human.load().shaped(made))
    name, most = ("heavy", MOST_HEAVY) if weight > usual else ("thin", MOST_THIN)
    at = lambda name, value: weight_of(human.load().shaped({**made, name: value}))
    values = np.linspace(0, most, 4)
    weights = [usual, *(at(name, value) for value in values[1:])]
    if not min(weights) <= weight <= max(weights):
        raise UsageError(
            f"Weight is {weight:g} kg; choose from {np.ceil(at('thin', MOST_THIN)):g} to "
            f"{np.floor(at('heavy', MOST_HEAVY)):g} kg for this height, age and gender."
        )
    volume = np.polyfit(values, np.array(weights) - weight, 3)  # of a mesh, in the third power of its offsets
    low, high = 0.0, most
    for _ in range(STEPS):
        middle = (low + high) / 2
        if (np.polyval(volume, middle) < 0) == (name == "heavy"):
            low = middle
        else:
            high = middle
    return {name: (low + high) / 2}


def weight_of(body: Human) -> float:
    """Return the weight of a body, kilogrammes: its volume times the density of living bodies."""
    corners = body.vertices[_triangles()]
    return DENSITY * float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


@functools.cache
def _triangles() -> np.ndarray:
    """Return vertex indices (F, 3) of the default human's faces, cut into triangles."""
    faces = human.load().faces
    second = faces[faces[:, 2] != faces[:, 3]][:, [0, 2, 3]]
    return np.concatenate([faces[:, :3], second])
