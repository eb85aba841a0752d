"""Walk Here: the character walks or runs to a point or a target."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty

from .job_operator import OptionsOperator

if TYPE_CHECKING:
    from ..samp_addon.pipeline.cast.cast import Cast
    from ..samp_addon.pipeline.job import Job


class SAMP_OT_walk_here(OptionsOperator, bpy.types.Operator):
    """Walk to the 3D cursor, around the furniture; each take becomes a new Action"""

    bl_idname = "samp.walk_here"
    bl_label = "Walk Here"

    location: FloatVectorProperty(
        name="Location", description="Destination if there is no target", subtype="TRANSLATION", size=3
    )
    use_yaw: BoolProperty(name="Custom Facing", description="Face a given direction at the end")
    yaw: FloatProperty(
        name="Facing",
        description="Facing at the end: rotation to the left from -Y, seen from above",
        subtype="ANGLE",
    )
    run: BoolProperty(name="Run", description="Run instead of walking")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if not self.properties.is_property_set("location"):
            self.location = context.scene.cursor.location
        return super().invoke(context, event)

    def job(self, context: bpy.types.Context) -> Job | Cast:
        from ..samp_addon.pipeline.job import Job

        facing = (math.degrees(self.yaw),) if self.use_yaw else ()
        place = None if self.target else (*self.location, *facing)
        cast = self.cast(context, "run" if self.run else "walk", place)
        if cast is not None:
            return cast
        return Job(action="run" if self.run else "walk", target=self.target, to=place, **self.common(context))
