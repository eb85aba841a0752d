"""What takes its time: done at once from Python and in background; beside a window in a thread, and Esc stops it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, NoReturn

import bpy

from . import outcome

if TYPE_CHECKING:
    from ..samp_addon.blender.thread_run import ThreadRun

TICK = 0.1
QUICK = 0.03  # seconds in which all is loaded that was loaded before
SLICE = 0.08  # seconds of writing between two ticks
UNDO_KEYS = {"Z"}


class ThreadOperator:
    """The operator has `at_once`, which does all of the work, `begin`, which starts it in a thread, and `told`."""

    bl_options = {"REGISTER", "UNDO"}

    _run = None
    _timer = None
    _ghost = None
    _slices = None
    _loading = False
    _asked_to_stop = False
    # The operator that works beside the window, if one does: there is never a second one.
    current: ThreadOperator | None = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if ThreadOperator.current is not None:
            cls.poll_message_set(f"Wait until '{ThreadOperator.current.bl_label}' is done, or cancel it")
            return False
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
        from ..samp_addon.blender import thread_run

        self._run = thread_run.loading()
        self._loading = not self._run.wait(QUICK)
        if not self._loading:
            self._start(context)
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(TICK, window=context.window)
        manager.modal_handler_add(self)
        ThreadOperator.current = self
        return ""

    def _start(self, context: bpy.types.Context) -> str:
        """The work itself, and the figure that shows it."""
        from ..samp_addon.blender.character import character
        from ..samp_addon.blender.overlays import ghost

        self._run = self.begin(context)
        owner = self._run.owner
        self._ghost = ghost.Ghost(None if owner is None else character.body_of(owner))
        return ""

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC" or self._asked_to_stop:
            self.cancel(context)
            self.report({"INFO"}, "Stopped; nothing was changed.")
            return {"CANCELLED"}
        if event.type == "TIMER" and self._run.done and self._loading:
            return self._loaded(context)
        if event.type == "TIMER" and self._run.done:
            return self._finish(context)
        if event.type == "TIMER":
            self._show(context)
        # All else goes on as ever; an undo meanwhile would take away what the work is for.
        undoing = event.type in UNDO_KEYS and (event.ctrl or event.oskey)
        return {"RUNNING_MODAL"} if undoing else {"PASS_THROUGH"}

    def _loaded(self, context: bpy.types.Context) -> set[str]:
        """Starts the work that waited for its programs to be loaded."""
        self._loading = False
        try:
            came = outcome.run(self, lambda: self._start(context), {"PASS_THROUGH"})
        except BaseException:
            self._clear(context)
            raise
        if came == {"CANCELLED"}:
            self._clear(context)
        return came

    def _finish(self, context: bpy.types.Context) -> set[str]:
        """Writes for a moment; Blender draws before the next one. Reports what came of it in the end."""
        self._slices = self._slices or self._run.finishing(context)
        until = time.perf_counter() + SLICE
        try:
            while time.perf_counter() < until:
                self._run.stage, self._run.share = next(self._slices)
        except StopIteration as end:
            result = end.value
        except Exception as error:
            self._clear(context)
            return outcome.run(self, _raise(error))
        else:
            self._show(context)
            return {"RUNNING_MODAL"}
        self._clear(context)
        return outcome.run(self, lambda: self.told(result))

    def cancel(self, context: bpy.types.Context) -> None:
        """Stops the work; also called by Blender when its window closes."""
        self._run.stop()
        if self._slices is not None:
            self._slices.close()  # takes away what is written already
        self._clear(context)

    def _show(self, context: bpy.types.Context) -> None:
        percent = int(100 * self._run.share)
        context.window_manager.progress_update(percent)
        context.workspace.status_text_set(f"{self.bl_label}: {self._run.stage} {percent} %   (Esc stops)")
        if self._ghost is not None:
            self._ghost.show(self._run.shown)
        _redraw(context)

    def _clear(self, context: bpy.types.Context) -> None:
        ThreadOperator.current = None
        if self._ghost is not None:
            self._ghost.remove()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        _redraw(context)


def _raise(error: BaseException) -> Callable[[], NoReturn]:
    def work() -> NoReturn:
        raise error

    return work


def _redraw(context: bpy.types.Context) -> None:
    """Has all 3D views drawn again, and their sidebars."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type in {"WINDOW", "UI"}:
                        region.tag_redraw()


def running() -> tuple[str, str, float] | None:
    """Of the work that goes on beside the window its name, stage and share done; None where there is none."""
    operator = ThreadOperator.current
    return operator and (operator.bl_label, operator._run.stage, operator._run.share)


def ask_to_stop() -> None:
    """Has the work that goes on beside the window stopped with the next tick."""
    if ThreadOperator.current is not None:
        ThreadOperator.current._asked_to_stop = True
