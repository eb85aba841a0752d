"""Plan Path: show the path to furniture or to the 3D cursor."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatVectorProperty, StringProperty

from . import outcome


class SAMP_OT_plan_path(bpy.types.Operator):
    """Plan the path from the character to the furniture, or to the 3D cursor, and show it as a curve"""

    bl_idname = "samp.plan_path"
    bl_label = "Plan Path"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Target",
        description="Object, empty or collection of the furniture; if empty, the selected furniture",
        options={"SKIP_SAVE"},
    )
    action: EnumProperty(
        name="Action",
        description="Action at the end of the path",
        items=(("sit", "Sit", "Path to a seat"), ("lie", "Lie", "Path to a place to lie")),
        default="sit",
    )
    to_cursor: BoolProperty(
        name="To 3D Cursor", description="End at the 3D cursor instead of the target", options={"SKIP_SAVE"}
    )
    use_start: BoolProperty(
        name="Custom Start",
        description="Start at a given location instead of the character's",
        options={"SKIP_SAVE"},
    )
    start: FloatVectorProperty(
        name="Start", description="Start of the path", subtype="TRANSLATION", options={"SKIP_SAVE"}
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
