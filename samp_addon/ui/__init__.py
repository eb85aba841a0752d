"""Panels, properties, preferences."""

from __future__ import annotations


def register(operators: tuple[str, ...]) -> None:
    """Shows these operators (ids without ``samp.``) in the sidebar."""
    import bpy

    from . import panel

    panel.shown = operators
    for cls in panel.CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Takes the panels away."""
    import bpy

    from . import panel

    for cls in reversed(panel.CLASSES):
        bpy.utils.unregister_class(cls)
