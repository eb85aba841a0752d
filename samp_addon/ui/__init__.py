"""Panels, lists, menus and their settings."""

from __future__ import annotations


def register() -> None:
    """Register the sidebar's tab, the lists and the menus."""
    import bpy

    from . import menu, settings

    for cls in _classes():
        bpy.utils.register_class(cls)
    settings.register()
    menu.register()


def unregister() -> None:
    """Unregister the sidebar."""
    import bpy

    from . import menu, settings

    menu.unregister()
    settings.unregister()
    for cls in reversed(_classes()):
        bpy.utils.unregister_class(cls)


def _classes() -> list[type]:
    """Return all classes; panels in the order of the sidebar."""
    from . import lists, menu, panel, settings, takes

    panels = (*panel.CLASSES, *takes.CLASSES, *panel.LATER, *lists.CLASSES, *panel.LAST)
    return [*settings.CLASSES, *menu.CLASSES, *panels]
