"""Takes follow by themselves, while the setting is on, once a target, goal or way-point was dragged."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ...errors import SampError
from .. import running_work
from ..actions import notes
from ..sub_goals.following import is_dragging

PAUSE = 0.2
"""Seconds between the artist's change and the new take, and between looks whether a drag is over."""

_refused: dict[str, str] = {}
"""What could not be followed: by the name of the take, the places then."""


def register() -> None:
    """Watch the objects that takes depend on."""
    bpy.app.handlers.depsgraph_update_post.append(_noticed)


def unregister() -> None:
    """Stop watching."""
    if _noticed in bpy.app.handlers.depsgraph_update_post:
        bpy.app.handlers.depsgraph_update_post.remove(_noticed)
    if bpy.app.timers.is_registered(follow):
        bpy.app.timers.unregister(follow)
    _refused.clear()


def follow() -> float | None:
    """Make the active take of the character again where something was moved; return the seconds until the next look
    while something runs."""
    context = bpy.context
    if running_work.current() is not None or is_dragging(context):
        return PAUSE
    owner = _behind(context)
    if owner is None:
        return None
    from . import following, origin

    action = owner.animation_data.action
    try:
        following.run(context, owner, action)
    except SampError:  # Follow, pressed by hand, says why
        _refused[action.name] = str(origin.places(context, origin.read(action).job))
        return None
    bpy.ops.ed.undo_push(message="Follow")
    return None


def _behind(context: bpy.types.Context) -> bpy.types.Object | None:
    """Return the character whose active take something was moved of, or None."""
    owner = context.scene.samp.character or context.view_layer.objects.active
    data = owner.animation_data if owner is not None and owner.type == "ARMATURE" else None
    action = None if data is None else data.action
    if not notes.is_take(action) or data.use_tweak_mode:
        return None
    from . import following, origin

    try:
        made = origin.read(action)
    except SampError:
        return None
    if not following.changes(context, made):
        return None
    return None if _refused.get(action.name) == str(origin.places(context, made.job)) else owner


@persistent
def _noticed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Called by Blender after every change: only waits for the end of a drag."""
    settings = getattr(scene, "samp", None)
    if settings is None or not settings.auto_follow or not depsgraph.id_type_updated("OBJECT"):
        return
    if not bpy.app.timers.is_registered(follow):
        bpy.app.timers.register(follow, first_interval=PAUSE)
