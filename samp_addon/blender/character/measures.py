"""The measures of a human that is made, as properties of the sidebar's settings and of Create Character."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import bpy
from bpy.props import BoolProperty, FloatProperty

PREFIX = "shape_"
HEIGHT, WEIGHT = 1.68, 60.0
LIMITS = {
    "height": (1.5, 2.0),
    "weight": (35.0, 160.0),
    "muscle": (0.0, 1.0),
    "age": (18.0, 100.0),
    "gender": (0.0, 1.0),
}
USUAL = {"muscle": 0.0, "age": 30.0, "gender": 0.5}
"""As in body/body_shape.py, which is not imported for these at every start."""
HELP = {
    "height": "Height from the soles to the top of the head, in metres",
    "weight": "Weight in kilogrammes",
    "muscle": "Muscles, from 0 for ordinary ones to 1 for strong ones",
    "age": "Age in years",
    "gender": "Gender, from 0 for a female figure to 1 for a male one",
}


def annotations() -> dict[str, object]:
    """Return the properties of the settings: a height, a weight if wanted, and the others."""
    found = {PREFIX + name: _property(name, value) for name, value in _defaults().items()}
    use = BoolProperty(
        name="Set Weight",
        description="Give the next character this weight; otherwise, the usual one for its height",
    )
    return found | {f"{PREFIX}use_weight": use}


def of_operator(**options: object) -> dict[str, object]:
    """Return the properties of an operator, where a height or a weight of 0 is the usual one. options: of them all."""
    usual = {name: _usual(name, options) for name in ("height", "weight")}
    return usual | {name: _property(name, value, options) for name, value in USUAL.items()}


def values(settings: bpy.types.PropertyGroup) -> dict[str, float]:
    """Return the measures that the settings ask for; none where all are as at first."""
    chosen = {name: round(getattr(settings, PREFIX + name), 4) for name in LIMITS}
    if not getattr(settings, f"{PREFIX}use_weight"):
        del chosen["weight"]
    changed = any(abs(value - _defaults()[name]) > 1e-4 for name, value in chosen.items() if name != "weight")
    return chosen if changed or "weight" in chosen else {}


def of_properties(operator: bpy.types.Operator) -> dict[str, float]:
    """Return the measures that an operator's properties ask for."""
    chosen = {name: round(getattr(operator, name), 4) for name in LIMITS}
    return {name: value for name, value in chosen.items() if is_set(name, value)}


def is_set(name: str, value: float) -> bool:
    """Return whether a value of an operator's property asks for something: not a height or a weight of 0."""
    return value > 0 or name in USUAL


def draw(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draw the measures."""
    column = layout.column(align=True)
    column.prop(settings, f"{PREFIX}height", slider=True)
    for name in USUAL:
        column.prop(settings, PREFIX + name, slider=True)
    layout.prop(settings, f"{PREFIX}use_weight")
    if getattr(settings, f"{PREFIX}use_weight"):
        layout.prop(settings, f"{PREFIX}weight", slider=True)


def _defaults() -> dict[str, float]:
    return {"height": HEIGHT, "weight": WEIGHT, **USUAL}


def _property(name: str, default: float, options: Mapping[str, object] = MappingProxyType({})) -> object:
    low, high = LIMITS[name]
    return FloatProperty(
        name=name.capitalize(),
        description=HELP[name],
        default=default,
        min=low,
        max=high,
        precision=2,
        **options,
    )


def _usual(name: str, options: Mapping[str, object]) -> object:
    low, high = LIMITS[name]
    return FloatProperty(
        name=name.capitalize(), description=f"{HELP[name]}; 0 for the usual one", default=0.0, min=0.0, soft_min=low,
        max=high, precision=2, **options,
    )  # fmt: skip
