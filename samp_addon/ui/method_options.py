"""The methods in the sidebar: the menu, and the options that one of them has alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty

from ..methods import registry

if TYPE_CHECKING:
    from ..methods.method import Method, Option

_items: list[tuple[str, str, str]] = []


def offered(name: str) -> bool:
    """Return whether there is a method of this name."""
    return name in registry.METHODS


def items(settings: bpy.types.PropertyGroup, context: bpy.types.Context) -> list[tuple[str, str, str]]:
    """Return the methods for an EnumProperty, the default one first."""
    names = sorted(registry.METHODS, key=lambda name: name != registry.DEFAULT)
    found = [(name, registry.METHODS[name].label, registry.METHODS[name].description) for name in names]
    if found != _items:  # Blender needs the strings to stay alive
        _items[:] = found
    return _items


def annotations() -> dict[str, object]:
    """Return a Blender property for each option that one value can set, by its name in the settings."""
    return {
        _name(method, option): _property(option)
        for method in registry.METHODS.values()
        for option in method.options
        if _shown(option)
    }


def draw(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup, method: Method) -> None:
    """Draw the chosen method's own options; of words, those of the chosen action."""
    for option in filter(_shown, method.options):
        name = _name(method, option)
        if not option.choices:
            layout.prop(settings, name)
            continue
        words = option.words(settings.action)
        if words:
            layout.label(text=name.removeprefix(f"{method.name}_").replace("_", " ").title())
            grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
            for word in words:
                grid.prop_enum(settings, name, word)


def values(settings: bpy.types.PropertyGroup, method: Method) -> dict[str, Any]:
    """Return what the chosen method's own options are set to; a text that is empty is left out."""
    found = {
        option.name: _text(option, getattr(settings, _name(method, option)))
        for option in method.options
        if _shown(option)
    }
    return {name: value for name, value in found.items() if value != ""}


def _shown(option: Option) -> bool:
    return not option.repeated and len(option.metavar) == 1


def _text(option: Option, value: Any) -> Any:
    """Return the value of an option; a set of words as one text."""
    return ",".join(word for word in option.choices if word in value) if option.choices else value


def _name(method: Method, option: Option) -> str:
    return f"{method.name}_{option.name}"


def _property(option: Option) -> object:
    own = {
        "name": option.name.replace("_", " ").title(),
        "description": option.help[:1].upper() + option.help[1:],
    }
    if option.choices:
        words = [(word, word.replace("_", " ").title(), f"{option.name}: {word}") for word in option.choices]
        return EnumProperty(**own, items=words, options={"ENUM_FLAG"}, default=set())
    if option.kind is str:
        return StringProperty(**own, default=option.default or "")
    limits = {"min": option.minimum, "max": option.maximum}
    limits = {name: value for name, value in limits.items() if value is not None}
    make = IntProperty if option.kind is int else FloatProperty
    return make(**own, default=option.default or option.kind(0), **limits)
