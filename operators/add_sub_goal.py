"""Add Sub-goal: a place that the take passes, at the 3D cursor or where one clicks, with a body."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, StringProperty

from . import outcome
from .sub_goal_operator import can_place


class SAMP_OT_add_sub_goal(bpy.types.Operator):
    """Add a sub-goal at the 3D cursor: on a floor the character stands, on a seat it sits, on a bed it lies"""

    bl_idname = "samp.add_sub_goal"
    bl_label = "Add Sub-goal"
    bl_options = {"REGISTER", "UNDO"}

    location: FloatVectorProperty(
        name="Location",
        description="Point on a floor, a seat or a bed; if not set, the 3D cursor",
        subtype="TRANSLATION",
        size=3,
        options={"SKIP_SAVE"},
    )
    use_yaw: BoolProperty(name="Custom Facing", description="Face a given direction", options={"SKIP_SAVE"})
    yaw: FloatProperty(
        name="Facing", description="Rotation to the left from facing -Y, seen from above", subtype="ANGLE"
    )
    click: BoolProperty(
        name="Click",
        description="Ask for a click on a floor, a seat or a bed in the 3D view",
        options={"SKIP_SAVE", "HIDDEN"},
    )
    character: StringProperty(
        name="Character",
        description="SMPL-X armature; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return "Click where to add a sub-goal: a floor, a seat or a bed" if properties.click else cls.__doc__

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return can_place(cls, context) and outcome.has_character(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if not self.click or bpy.app.background:
            return self.execute(context)
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set("Click a floor, a seat or a bed   (Esc stops)")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        from ..samp_addon.blender.sub_goals import clicking

        point = clicking.surface_under(context, event.mouse_x, event.mouse_y)
        if point is None:
            return {"RUNNING_MODAL"}
        self.location = point
        self.cancel(context)
        return self.execute(context)

    def cancel(self, context: bpy.types.Context) -> None:
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)

    def execute(self, context: bpy.types.Context) -> set[str]:
        if not self.properties.is_property_set("location"):
            self.location = context.scene.cursor.location
        return outcome.run(self, lambda: self._add(context))

    def _add(self, context: bpy.types.Context) -> str:
        from ..samp_addon import frames
        from ..samp_addon.blender.sub_goals import placing
        from ..samp_addon.ui import sub_goal_settings

        settings = context.scene.samp
        owner = sub_goal_settings.character(context, self.character)
        point = frames.to_network(list(self.location))
        yaw = self.yaw if self.use_yaw else None
        arrow = placing.add(context, owner, point, yaw, round(settings.style, 4))
        sub_goal_settings.activate(context, arrow)
        return f"Added '{arrow.name}'."
