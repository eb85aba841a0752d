"""Sample Goals: arrows where a character can sit or lie on the furniture."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import outcome


class SAMP_OT_sample_goals(bpy.types.Operator):
    """Find places to sit or lie on an object; move, turn, select or delete the arrows to have your way"""

    bl_idname = "samp.sample_goals"
    bl_label = "Sample Goals"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Target",
        description="Object, empty or collection of the furniture; empty: what is selected",
        options={"SKIP_SAVE"},
    )
    action: EnumProperty(
        name="Action",
        items=(("sit", "Sit", "Places to sit on"), ("lie", "Lie", "Places to lie on")),
        default="sit",
    )
    count: IntProperty(name="Count", description="How many arrows", default=5, min=1, max=64)
    seed: IntProperty(name="Seed", description="Other goals for another seed", default=0, min=0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._sample(context))

    def _sample(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.overlays import goal_arrows
        from ..samp_addon.blender.scene import targets

        target = self.target or targets.clicked_target(context)
        made = goal_arrows.sample_goals(context, target, self.action, self.count, self.seed)
        return f"Placed {len(made)} goal{'s' if len(made) > 1 else ''} on '{target}'."
