"""The trails of the active take, drawn into the 3D Viewport while the setting is on; never into renders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ...errors import SampError
from ..actions import keyframes, notes

if TYPE_CHECKING:
    from ...edits.trails import Trails

WIDTH = 2.5
"""Pixels of lines."""
CROSS = np.array([[0.03, 0.03, 0.0], [0.03, -0.03, 0.0]])
"""Metres from the middle of the cross where a foot stands to the ends of its arms."""

_handles: list[object] = []
_known: dict[tuple, Trails | None] = {}


def register() -> None:
    """Draw trails in all 3D Viewports whose scene has the setting on."""
    _handles.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))
    bpy.app.handlers.depsgraph_update_post.append(_changed)


def unregister() -> None:
    """Stop drawing."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    if _changed in bpy.app.handlers.depsgraph_update_post:
        bpy.app.handlers.depsgraph_update_post.remove(_changed)
    _known.clear()


def of_owner(context: bpy.types.Context, owner: bpy.types.Object) -> Trails | None:
    """Return the trails of an armature's active take, network frame, or None where it has none."""
    data = owner.animation_data
    action = None if data is None else data.action
    if not notes.is_take(action):
        return None
    key = owner.name, action.name, tuple(action.frame_range), tuple(map(tuple, owner.matrix_world))
    if key not in _known:
        from ...edits import trails

        _known.clear()
        try:
            _known[key] = trails.trails(keyframes.read_motion(owner, action, scene=context.scene))
        except SampError:
            _known[key] = None
    return _known[key]


def _owner(context: bpy.types.Context) -> bpy.types.Object | None:
    """Return the character of the settings, or the active armature."""
    chosen = context.scene.samp.character or context.view_layer.objects.active
    return chosen if chosen is not None and chosen.type == "ARMATURE" else None


def _draw() -> None:
    context = bpy.context
    settings = getattr(context.scene, "samp", None)
    overlay = getattr(context.space_data, "overlay", None)
    if settings is None or not settings.show_trails or overlay is None or not overlay.show_overlays:
        return
    owner = _owner(context)
    found = None if owner is None else of_owner(context, owner)
    if found is not None:
        _paint(found)


def _paint(found: Trails) -> None:
    """Draw lines on the GPU."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    from ... import frames
    from ...edits.trails import RED, STANDS

    lines = [frames.to_blender(found.points.reshape(-1, 3))]
    colours = [found.colours.repeat(2, axis=0)]
    for arm in CROSS:  # a cross where a foot stands
        lines.append((frames.to_blender(found.stands)[:, None] + [-arm, arm]).reshape(-1, 3))
        shades = np.where(found.slides[:, None], RED, STANDS).reshape(-1, 4)
        colours.append(shades.repeat(2, axis=0))
    shader = gpu.shader.from_builtin("POLYLINE_FLAT_COLOR")
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", WIDTH)
    content = {"pos": np.concatenate(lines).tolist(), "color": np.concatenate(colours).tolist()}
    batch_for_shader(shader, "LINES", content).draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


@persistent
def _changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Called by Blender after every change: trails of edited Actions are computed again."""
    if _known and depsgraph.id_type_updated("ACTION"):
        _known.clear()
