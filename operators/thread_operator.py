"""What takes its time: done at once from Python and in background; from a window with progress, and Esc stops it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from . import outcome

if TYPE_CHECKING:
    from ..samp_addon.blender.thread_run import ThreadRun

TICK = 0.1
NAVIGATION = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM"}


class ThreadOperator:
    """The operator has `at_once`, which does all of the work, `begin`, which starts it in a thread, and `told`."""

    bl_options = {"REGISTER", "UNDO"}

    _run = None
    _timer = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def at_once(self, context: bpy.types.Context) -> object:
        """Does the work; returns what `told` needs."""
        raise NotImplementedError

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        """Starts the work in a thread; what it writes in the end is what `told` needs."""
        raise NotImplementedError

    def told(self, result: object) -> str:
        """What the artist is told of work that is done."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self.told(self.at_once(context)))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        return outcome.run(self, lambda: self._begin(context), {"RUNNING_MODAL"})

    def _begin(self, context: bpy.types.Context) -> str:
        self._run = self.begin(context)
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
            return outcome.run(self, lambda: self.told(self._run.finish(context)))
        if event.type == "TIMER":
            self._show(context)
        return {"PASS_THROUGH"} if event.type in NAVIGATION else {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Stops the work; also called by Blender when its window closes."""
        self._run.stop()
        self._clear(context)

    def _show(self, context: bpy.types.Context) -> None:
        percent = int(100 * self._run.share)
        context.window_manager.progress_update(percent)
        context.workspace.status_text_set(f"{self.bl_label}: {self._run.stage} {percent} %   (Esc stops)")

    def _clear(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
