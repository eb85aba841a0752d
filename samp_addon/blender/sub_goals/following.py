"""Ghosts follow: after an arrow is moved, turned, copied or deleted, bodies are fitted again by themselves."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from .. import running_work
from . import arrows

PAUSE = 0.2
"""Seconds between the artist's change and the new body, and between looks whether a drag is over."""

_given_up: list[bool] = []


def register() -> None:
    """Watch the arrows."""
    bpy.app.handlers.depsgraph_update_post.append(_noticed)


def unregister() -> None:
    """Stop watching."""
    if _noticed in bpy.app.handlers.depsgraph_update_post:
        bpy.app.handlers.depsgraph_update_post.remove(_noticed)
    if bpy.app.timers.is_registered(follow):
        bpy.app.timers.unregister(follow)


def is_behind(scene: bpy.types.Scene) -> bool:
    """Return whether an arrow of a scene has changed since its body was fitted."""
    home = arrows.collection(scene)
    if home is None:
        return False
    from . import ghosts, stored

    there = [obj for obj in home.objects if arrows.is_arrow(obj)]
    alone = any(ghosts.is_ghost(obj) and obj.parent is None for obj in home.objects)
    return alone or any(stored.is_stale(arrow) for arrow in there if arrows.owner_of(arrow) is not None)


def follow() -> float | None:
    """Fit bodies again where arrows have changed; return the seconds until the next look while something runs."""
    context = bpy.context
    if running_work.current() is not None or is_dragging(context):
        return PAUSE
    if not is_behind(context.scene):
        return None
    from ...methods import registry
    from . import placing

    if _given_up or placing.METHOD not in registry.METHODS:
        return None
    try:
        for owner in arrows.owners(context) or [None]:
            placing.update(context, owner)
    except (ImportError, OSError):  # a package is missing: operators say which one
        _given_up.append(True)
    return None


def is_dragging(context: bpy.types.Context) -> bool:
    """Return whether a tool such as Move is running in a window."""
    return any(
        tool.bl_idname.startswith("TRANSFORM_OT_")
        for window in context.window_manager.windows
        for tool in getattr(window, "modal_operators", ())
    )


@persistent
def _noticed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Called by Blender after every change: only looks, since nothing may be changed here."""
    if not bpy.app.timers.is_registered(follow) and is_behind(scene):
        bpy.app.timers.register(follow, first_interval=PAUSE)
