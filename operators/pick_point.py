"""The click on a piece of a room: the first part of an operator whose target is a whole room."""

from __future__ import annotations

import bpy
from bpy.props import FloatVectorProperty


class PickPoint:
    """Mixin, before the operator's other bases: if its target is a whole room, the mouse asks which piece is meant.

    From Python and where `location` is given nothing is asked. `target_name` returns the name of the target.
    """

    location: FloatVectorProperty(
        name="Location",
        description="Point on the target; in a room that is one mesh it selects the piece",
        subtype="TRANSLATION",
        size=3,
        options={"SKIP_SAVE"},
    )

    _picking = False

    def target_name(self, context: bpy.types.Context) -> str:
        """Return the name of the target. Raise SampError where there is none."""
        raise NotImplementedError

    def point(self) -> tuple[float, float, float] | None:
        """Return the point on the target that was clicked or given, or None."""
        return tuple(self.location) if self.properties.is_property_set("location") else None

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        from ..samp_addon.blender.scene import targets
        from ..samp_addon.errors import SampError

        if bpy.app.background or self.point() is not None:
            return super().invoke(context, event)
        try:
            name = self.target_name(context)
        except SampError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not targets.is_room(context, name):
            return super().invoke(context, event)
        self._picking = True
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set(f"Click the furniture in '{name}'   (Esc stops)")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if not self._picking:
            return super().modal(context, event)
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self._end(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        from ..samp_addon.blender.scene import targets

        point = targets.point_under(context, event.mouse_x, event.mouse_y, self.target_name(context))
        if point is None:
            return {"RUNNING_MODAL"}
        self.location = point
        self._end(context)
        return self.start_work(context, handled=True)

    def cancel(self, context: bpy.types.Context) -> None:
        if self._picking:
            self._end(context)
        else:
            super().cancel(context)

    def _end(self, context: bpy.types.Context) -> None:
        self._picking = False
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
