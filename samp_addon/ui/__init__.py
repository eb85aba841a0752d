"""Panels, lists, menus and their settings."""

from __future__ import annotations


def register() -> None:
    """Register the sidebar's tab, the lists and the menus."""
    import bpy

    from . import keys, menu, presets, settings

    settings.register()
    for cls in _classes():
        bpy.utils.register_class(cls)
    menu.register()
    keys.register()
    presets.register()


def unregister() -> None:
    """Unregister the sidebar."""
    import bpy

    from . import keys, menu, presets, settings

    presets.unregister()
    keys.unregister()
    menu.unregister()
    for cls in reversed(_classes()):
        bpy.utils.unregister_class(cls)
    settings.unregister()


def _classes() -> list[type]:
    """Return all classes but the settings; panels in the order of the sidebar."""
    from . import keys, lists, menu, panel, presets, sub_goals, takes
    from .cast import panel as cast
    from .farm import panel as farm

    panels = [*panel.CLASSES, *sub_goals.CLASSES, *takes.CLASSES, *panel.LATER]
    panels += [*cast.CLASSES, *lists.CLASSES, *panel.LAST, *farm.CLASSES]
    return [*menu.CLASSES, *keys.CLASSES, *presets.CLASSES, *panels]
