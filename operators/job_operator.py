"""What Sit Here, Lie Here and Walk Here have in common: a job, its progress, and how to stop it."""

from __future__ import annotations

import math

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from . import outcome

TICK = 0.1
NAVIGATION = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM"}


class JobOperator:
    """Does the whole job at once from Python and in background; from a window in a thread, with progress."""

    bl_options = {"REGISTER", "UNDO"}

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
    use_start: BoolProperty(name="Own Start", description="Start elsewhere than where the character stands")
    start: FloatVectorProperty(name="Start", description="Where to start", subtype="TRANSLATION", size=3)
    start_yaw: FloatProperty(
        name="Start Facing", description="Turn to the left from facing -Y, seen from above", subtype="ANGLE"
    )

    _run = None
    _timer = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.mode not in {"OBJECT", "POSE"}:
            cls.poll_message_set("Go to Object or Pose Mode first")
            return False
        return True

    def common(self) -> dict:
        """The options of every job."""
        start = (*self.start, math.degrees(self.start_yaw)) if self.use_start else None
        return {
            "character": self.character,
            "seed": self.seed,
            "variants": self.variants,
            "hold": self.hold,
            "start": start,
        }

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._bake(context))

    def _bake(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender import jobs

        return jobs.sentence(jobs.run(context, self.job(context)))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        return outcome.run(self, lambda: self._begin(context), {"RUNNING_MODAL"})

    def _begin(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.job_run import JobRun

        self._run = JobRun(context, self.job(context))
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(TICK, window=context.window)
        manager.modal_handler_add(self)
        return ""

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            self.cancel(context)
            self.report({"INFO"}, "Stopped; nothing was changed.")
            return {"CANCELLED"}
        if event.type == "TIMER" and self._run.done:
            self._clear(context)
            return outcome.run(self, lambda: self._finish(context))
        if event.type == "TIMER":
            self._show(context)
        return {"PASS_THROUGH"} if event.type in NAVIGATION else {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Stops the work; also called by Blender when its window closes."""
        self._run.stop()
        self._clear(context)

    def _finish(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender import jobs

        return jobs.sentence(self._run.finish(context))

    def _show(self, context: bpy.types.Context) -> None:
        percent = int(100 * self._run.share)
        context.window_manager.progress_update(percent)
        context.workspace.status_text_set(f"{self.bl_label}: {self._run.stage} {percent} %   (Esc stops)")

    def _clear(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
