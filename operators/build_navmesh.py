"""Build Navmesh: show the walkable ground."""

from __future__ import annotations

import math

import bpy
from bpy.props import FloatProperty

from . import outcome


class SAMP_OT_build_navmesh(bpy.types.Operator):
    """Build the navmesh of the scene and show where a character can walk"""

    bl_idname = "samp.build_navmesh"
    bl_label = "Build Navmesh"
    bl_options = {"REGISTER", "UNDO"}

    radius: FloatProperty(
        name="Radius", description="Radius of the character", default=0.22, min=0.05, max=2, unit="LENGTH"
    )
    height: FloatProperty(
        name="Height",
        description="Height that the character needs to stand",
        default=1.7,
        min=0.2,
        max=5,
        unit="LENGTH",
    )
    step: FloatProperty(
        name="Step",
        description="Highest step that the character climbs",
        default=0.25,
        min=0,
        max=1,
        unit="LENGTH",
    )
    slope: FloatProperty(
        name="Slope",
        description="Steepest slope that the character walks on",
        default=math.radians(40),
        min=0,
        max=math.radians(80),
        subtype="ANGLE",
    )
    cell: FloatProperty(
        name="Cell",
        description="Size of the cells in which the ground is sampled",
        default=0.05,
        min=0.02,
        max=0.5,
        unit="LENGTH",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._build(context))

    def _build(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.overlays import previews

        agent = previews.Agent(self.radius, self.height, self.step, self.slope)
        shown, mesh = previews.build_navmesh(context, agent, self.cell)
        laid = "; the scene has no floor, so one was assumed" if mesh.laid_ground is not None else ""
        return f"'{shown.name}' shows {mesh.area:.0f} m2 of walkable ground in {len(mesh)} polygons{laid}."
