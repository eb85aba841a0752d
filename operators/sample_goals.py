"""Sample Goals: draw arrows where a character can sit or lie on furniture."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import outcome


class SAMP_OT_sample_goals(bpy.types.Operator):
    """Sample places to sit or lie on the furniture and draw them as arrows, which can be moved, selected and deleted"""

    bl_idname = "samp.sample_goals"
    bl_label = "Sample Goals"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Target",
        description="Object, empty or collection of the furniture; if empty, the selected furniture",
        options={"SKIP_SAVE"},
    )
    action: EnumProperty(
        name="Action",
        description="Action at the goals",
        items=(("sit", "Sit", "Places to sit"), ("lie", "Lie", "Places to lie")),
        default="sit",
    )
    count: IntProperty(name="Count", description="Number of goals", default=5, min=1, max=64)
    seed: IntProperty(name="Seed", description="Seed of the random numbers", default=0, min=0)

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
