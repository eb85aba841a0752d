"""Edit Steps: add, remove and move steps."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty


class SAMP_OT_edit_chain(bpy.types.Operator):
    """Add, remove or move a step"""

    bl_idname = "samp.edit_chain"
    bl_label = "Edit Steps"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    change: EnumProperty(
        name="Change",
        description="How to change the list of steps",
        items=(
            ("ADD", "Add", "Add a step with the current action and target"),
            ("REMOVE", "Remove", "Remove the active step"),
            ("UP", "Up", "Move the active step up"),
            ("DOWN", "Down", "Move the active step down"),
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
            step.method = settings.method
            step.action, step.target = settings.action, settings.target or self._selected_target(context)
            step.place = context.scene.cursor.location
            settings.step_index = len(steps) - 1
        elif not 0 <= at < len(steps):
            self.report({"INFO"}, "No step is active; click one in the list.")
            return {"CANCELLED"}
        elif self.change == "REMOVE":
            steps.remove(at)
            settings.step_index = max(0, min(at, len(steps) - 1))
        else:
            to = max(0, min(at + (1 if self.change == "DOWN" else -1), len(steps) - 1))
            steps.move(at, to)
            settings.step_index = to
        return {"FINISHED"}

    def _selected_target(self, context: bpy.types.Context) -> bpy.types.Object | None:
        """Return the furniture that is active or selected, for actions that need a target."""
        from ..samp_addon.blender.scene import targets
        from ..samp_addon.errors import SampError
        from ..samp_addon.vocabulary import SEATED

        if context.scene.samp.action not in SEATED:
            return None
        try:
            return context.scene.objects.get(targets.clicked_target(context))
        except SampError:
            return None
