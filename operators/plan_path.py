"""Plan Path: the way around the furniture to a seat or a place."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatVectorProperty, StringProperty

from . import outcome


class SAMP_OT_plan_path(bpy.types.Operator):
    """Show the way from the character to the furniture, or to the 3D cursor"""

    bl_idname = "samp.plan_path"
    bl_label = "Plan Path"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Target",
        description="Object, empty or collection of the furniture; empty: what is selected",
        options={"SKIP_SAVE"},
    )
    action: EnumProperty(
        name="Action",
        items=(("sit", "Sit", "The way to a seat"), ("lie", "Lie", "The way to a bed")),
        default="sit",
    )
    to_cursor: BoolProperty(
        name="To 3D Cursor", description="Walk to the 3D cursor instead", options={"SKIP_SAVE"}
    )
    use_start: BoolProperty(
        name="Other Start", description="Start elsewhere than at the character", options={"SKIP_SAVE"}
    )
    start: FloatVectorProperty(
        name="Start", description="Where the way starts", subtype="TRANSLATION", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._plan(context))

    def _plan(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.overlays import previews
        from ..samp_addon.blender.scene import targets

        start = tuple(self.start) if self.use_start else None
        if self.to_cursor:
            shown, path = previews.plan_path(context, to=tuple(context.scene.cursor.location), start=start)
        else:
            target = self.target or targets.clicked_target(context)
            shown, path = previews.plan_path(context, target, start=start, action=self.action)
        return f"'{shown.name}' is {path.length:.1f} m long and has {len(path.waypoints)} way-points."
