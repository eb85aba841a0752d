"""Draw Path: a line on the floor, or a curve, becomes way-points that the path passes."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome

HINT = "Drag on the floor to draw the path   (Esc stops)"


class SAMP_OT_draw_path(bpy.types.Operator):
    """Draw the path of the next take on the floor; the line becomes way-points, which can be moved like any object"""

    bl_idname = "samp.draw_path"
    bl_label = "Draw Path"
    bl_options = {"UNDO"}  # without REGISTER: the redo panel does not know the line

    curve: StringProperty(
        name="Curve",
        description="Curve object that is the path; if empty, the path is drawn with the mouse",
        options={"SKIP_SAVE"},
    )

    _line = None
    _figure = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if self.curve or bpy.app.background:
            return self.execute(context)
        from ..samp_addon.blender.placing import figure

        self._figure = figure.PlaceFigure()
        context.window.cursor_modal_set("PAINT_BRUSH")
        context.workspace.status_text_set(HINT)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            self._line = []
            self._go_on(context, event)
            return {"RUNNING_MODAL"}
        if self._line is None:
            return {"PASS_THROUGH"}
        if event.type == "MOUSEMOVE":
            self._go_on(context, event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            if len(self._line) < 2:
                self._line = None
                return {"RUNNING_MODAL"}
            self.cancel(context)
            return self.execute(context)
        return {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        self._figure.remove()
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        self._figure.redraw(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._add(context))

    def _add(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.placing import strokes
        from ..samp_addon.errors import SampError

        line = self._line
        if not line:
            active = context.view_layer.objects.active
            name = self.curve or (active.name if active is not None and active.type == "CURVE" else "")
            if not name:
                raise SampError("There is no line; name a curve, or make one active.")
            line = strokes.of_curve(context, name)
        made = strokes.add(context, line)
        return f"Added {len(made)} way-points."

    def _go_on(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        """Add the point of the floor under the mouse to the line."""
        import numpy as np

        from ..samp_addon.blender.sub_goals import clicking

        point = clicking.surface_under(context, event.mouse_x, event.mouse_y)
        if point is not None:
            self._line.append(point)
            self._figure.stroke(np.array(self._line) + [0.0, 0.0, 0.02])
            self._figure.redraw(context)
