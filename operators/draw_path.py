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
        from ..samp_addon.blender.placing import drawn_line, figure

        self._figure = figure.PlaceFigure()
        self._line = drawn_line.DrawnLine(self._figure)
        context.window.cursor_modal_set("PAINT_BRUSH")
        context.workspace.status_text_set(HINT)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        begun = self._line.begun
        if self._line.handle(context, event):
            self.cancel(context)
            return self.execute(context)
        return {"RUNNING_MODAL"} if begun or self._line.begun else {"PASS_THROUGH"}

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

        if self._line is not None:
            made = self._line.add(context)
        else:
            active = context.view_layer.objects.active
            name = self.curve or (active.name if active is not None and active.type == "CURVE" else "")
            if not name:
                raise SampError("There is no line; name a curve, or make one active.")
            made = strokes.add(context, strokes.of_curve(context, name))
        return f"Added {len(made)} way-points."
