"""Reduce Keys: a copy of a take with fewer keys."""

from __future__ import annotations

import bpy
from bpy.props import FloatProperty

from .take_operator import TakeOperator


class SAMP_OT_reduce_keys(TakeOperator, bpy.types.Operator):
    """Copy this take with as few keys as a bound on the error allows, so that its curves can be edited"""

    bl_idname = "samp.reduce_keys"
    bl_label = "Reduce Keys"

    distance: FloatProperty(
        name="Distance",
        description="Largest error of the pelvis in any frame",
        default=0.001,
        min=1e-5,
        soft_max=0.02,
        precision=4,
        subtype="DISTANCE",
    )
    angle: FloatProperty(
        name="Angle",
        description="Largest error of each bone's rotation in any frame, degrees",
        default=0.1,
        min=0.001,
        soft_max=2.0,
        precision=3,
    )

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.actions import reduce_keys

        return reduce_keys.run(self.owner(context), take, self.distance, self.angle).sentence()
