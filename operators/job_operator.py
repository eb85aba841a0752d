"""What Sit Here, Lie Here and Walk Here have in common: the options of a job."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.takes.baking import Result
    from ..samp_addon.blender.thread_run import ThreadRun


class JobOperator(ThreadOperator):
    """The operator has `job`, which makes the job of these options and its own."""

    target: StringProperty(
        name="Target",
        description="Object, empty or collection of the furniture; empty: what is selected",
        options={"SKIP_SAVE"},
    )
    character: StringProperty(
        name="Character",
        description="SMPL-X armature; empty: the selected one, the only one, or a new human",
        options={"SKIP_SAVE"},
    )
    seed: IntProperty(name="Seed", description="Another seed gives another take", default=0, min=0)
    variants: IntProperty(name="Takes", description="Each is an Action of its own", default=1, min=1, max=64)
    hold: FloatProperty(
        name="Hold",
        description="Seconds at the end",
        default=2.0,
        min=0.0,
        max=600.0,
        subtype="TIME_ABSOLUTE",
    )
    refine: BoolProperty(
        name="Refine", description="Mend contact, penetration and foot slide of each take; takes longer"
    )
    use_start: BoolProperty(name="Own Start", description="Start elsewhere than where the character stands")
    start: FloatVectorProperty(name="Start", description="Where to start", subtype="TRANSLATION", size=3)
    start_yaw: FloatProperty(
        name="Start Facing", description="Turn to the left from facing -Y, seen from above", subtype="ANGLE"
    )

    def common(self) -> dict:
        """The options of every job."""
        start = (*self.start, math.degrees(self.start_yaw)) if self.use_start else None
        return {
            "character": self.character,
            "seed": self.seed,
            "variants": self.variants,
            "hold": self.hold,
            "refine": self.refine,
            "start": start,
        }

    def at_once(self, context: bpy.types.Context) -> Result:
        from ..samp_addon.blender.takes import baking

        return baking.run(context, self.job(context))

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.takes import baking

        return baking.begin(context, self.job(context))

    def told(self, result: Result) -> str:
        from ..samp_addon.blender.takes import baking

        return baking.sentence(result)
