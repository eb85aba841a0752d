"""Clear Overlays: delete goals, way-points, navmesh, path and voxels."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from . import outcome


class SAMP_OT_clear_overlays(bpy.types.Operator):
    """Delete the goals, way-points, navmesh, path and voxels that SAMP has added to the scene"""

    bl_idname = "samp.clear_overlays"
    bl_label = "Clear Overlays"
    bl_options = {"REGISTER", "UNDO"}

    what: EnumProperty(
        name="What",
        description="Kind of overlays to delete",
        items=(
            ("ALL", "All", "Goals, way-points, navmesh, path and voxels"),
            ("GOALS", "Goals", "Arrows of goals"),
            ("WAYPOINTS", "Way-points", "Way-points of the path"),
            ("PICTURES", "Pictures", "Navmesh, path and voxels"),
        ),
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._clear(context))

    def _clear(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.overlays import drawing, goal_arrows, waypoints

        clears = {"GOALS": goal_arrows.clear, "WAYPOINTS": waypoints.clear, "PICTURES": drawing.clear}
        count = sum(clear(context) for name, clear in clears.items() if self.what in ("ALL", name))
        return f"Cleared {count} object{'' if count == 1 else 's'}."
