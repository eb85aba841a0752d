"""Voxelise: show the voxel grid of a piece of furniture."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome


class SAMP_OT_voxelise(bpy.types.Operator):
    """Show the 8 x 8 x 8 voxel grid of the furniture, which is the networks' input"""

    bl_idname = "samp.voxelise"
    bl_label = "Voxelise"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Target",
        description="Object, empty or collection of the furniture; if empty, the selected furniture",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._voxelise(context))

    def _voxelise(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.overlays import previews
        from ..samp_addon.blender.scene import targets

        shown, grid = previews.voxelise(context, self.target or targets.clicked_target(context))
        return f"'{shown.name}' shows the {int((grid.occupancy > 0).sum())} occupied cells."
