"""Edit Chain: steps are added, taken away and moved."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty


class SAMP_OT_edit_chain(bpy.types.Operator):
    """Change the steps of the chain"""

    bl_idname = "samp.edit_chain"
    bl_label = "Edit Chain"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    change: EnumProperty(
        name="Change",
        items=(
            ("ADD", "Add", "A step with the action and target chosen above"),
            ("REMOVE", "Remove", "Take the chosen step away"),
            ("UP", "Up", "Do the chosen step earlier"),
            ("DOWN", "Down", "Do the chosen step later"),
        ),
    )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return cls.bl_rna.properties["change"].enum_items[properties.change].description

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.scene.samp
        steps, at = settings.steps, settings.step_index
        if self.change == "ADD":
            step = steps.add()
            step.action, step.target = settings.action, settings.target or self._clicked(context)
            step.place = context.scene.cursor.location
            settings.step_index = len(steps) - 1
        elif not 0 <= at < len(steps):
            self.report({"INFO"}, "No step is chosen; click one in the list.")
            return {"CANCELLED"}
        elif self.change == "REMOVE":
            steps.remove(at)
            settings.step_index = max(0, min(at, len(steps) - 1))
        else:
            to = max(0, min(at + (1 if self.change == "DOWN" else -1), len(steps) - 1))
            steps.move(at, to)
            settings.step_index = to
        return {"FINISHED"}

    def _clicked(self, context: bpy.types.Context) -> bpy.types.Object | None:
        """The furniture that is active or selected, for actions that need one."""
        from ..samp_addon.blender.scene import targets
        from ..samp_addon.errors import SampError

        if context.scene.samp.action not in ("sit", "lie"):
            return None
        try:
            return context.scene.objects.get(targets.clicked_target(context))
        except SampError:
            return None
