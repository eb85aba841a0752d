"""Panels, lists, menus and what is set in them."""

from __future__ import annotations


def register() -> None:
    """Add the sidebar's tab, the lists and the menus."""
    import bpy

    from . import menu, settings

    for cls in _classes():
        bpy.utils.register_class(cls)
    settings.add_to_scenes()
    menu.add()


def unregister() -> None:
    """Remove all of it."""
    import bpy

    from . import menu, settings

    menu.remove()
    settings.take_from_scenes()
    for cls in reversed(_classes()):
        bpy.utils.unregister_class(cls)


def _classes() -> list[type]:
    """In the order in which the panels stand below each other."""
    from . import lists, menu, panel, settings

    panels = (*panel.CLASSES, *lists.CLASSES, *panel.LATER, *lists.LATER, *panel.LAST)
    return [*settings.CLASSES, *menu.CLASSES, *panels]
