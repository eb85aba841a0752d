"""Panels, lists, menus and what is set in them."""

from __future__ import annotations

from collections.abc import Callable


def register(running: Callable[[], tuple[str, str, float] | None]) -> None:
    """Shows the sidebar's tab. running: asks for the work that goes on beside the window."""
    import bpy

    from . import menu, panel, settings

    panel.running = running
    for cls in _classes():
        bpy.utils.register_class(cls)
    settings.add_to_scenes()
    menu.add()


def unregister() -> None:
    """Takes all of it away."""
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
