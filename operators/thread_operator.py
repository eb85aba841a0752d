"""Long work: done at once from Python and in background; in a thread beside a window, where Esc cancels it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, NoReturn

import bpy

from ..samp_addon.blender import running_work
from . import outcome

if TYPE_CHECKING:
    from ..samp_addon.blender.thread_run import ThreadRun

TICK = 0.1
QUICK = 0.03  # seconds within which everything is loaded that was loaded before
SLICE = 0.08  # seconds of writing between two redraws
UNDO_KEYS = {"Z"}


class ThreadOperator:
    """Base of operators with long work: `run_now` does all of it, `begin` starts it in a thread, `finished` ends it."""

    bl_options = {"UNDO"}  # without REGISTER: the redo panel would run it again without progress

    _work = None
    _run = None
    _timer = None
    _ghost = None
    _slices = None
    _loading = False

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        work = running_work.current()
        if work is not None:
            cls.poll_message_set(f"Wait until '{work.label}' is done, or cancel it")
            return False
        return outcome.in_object_or_pose_mode(cls, context)

    def run_now(self, context: bpy.types.Context) -> object:
        """Do the work; return what `finished` needs."""
        raise NotImplementedError

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        """Start the work in a thread; what it writes in the end is what `finished` needs."""
        raise NotImplementedError

    def finished(self, result: object) -> str:
        """Do what remains after the work; return the sentence that is reported."""
        raise NotImplementedError

    def label(self, context: bpy.types.Context) -> str:
        """Return the text of the button that was pressed."""
        return self.bl_label

    def method_used(self, context: bpy.types.Context) -> str | None:
        """Return the name of the method whose networks are loaded first, or None for the default method."""
        return None

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self.finished(self.run_now(context)))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        return self.start_work(context)

    def start_work(self, context: bpy.types.Context, handled: bool = False) -> set[str]:
        """Start the work beside the window. handled: whether the operator receives events already."""
        return outcome.run(self, lambda: self._begin(context, handled), {"RUNNING_MODAL"})

    def _begin(self, context: bpy.types.Context, handled: bool = False) -> str:
        from ..samp_addon.blender.takes import loading

        self._run = loading.begin(self.method_used(context))
        self._loading = not self._run.wait(QUICK)
        if not self._loading:
            self._start(context)
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(TICK, window=context.window)
        if not handled:
            manager.modal_handler_add(self)
        self._work = running_work.begin(self.label(context), type(self).__name__.removeprefix("SAMP_OT_"))
        return ""

    def _start(self, context: bpy.types.Context) -> str:
        """Start the work itself, and the figure that previews it."""
        from ..samp_addon.blender.overlays import ghost
        from ..samp_addon.blender.rigs import performers

        self._run = self.begin(context)
        owner = self._run.owner
        self._ghost = ghost.Ghost(None if owner is None else performers.body_of(owner))
        return ""

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if _escape(context, event) or self._work.cancel_requested:
            self.cancel(context)
            self.report({"INFO"}, "Stopped; nothing was changed.")
            return {"CANCELLED"}
        if event.type == "TIMER" and self._run.done and self._loading:
            return self._loaded(context)
        if event.type == "TIMER" and self._run.done:
            return self._finish(context)
        if event.type == "TIMER":
            self._show(context)
        # All other events pass through; an undo in between would remove what the work is for.
        undoing = event.type in UNDO_KEYS and (event.ctrl or event.oskey)
        return {"RUNNING_MODAL"} if undoing else {"PASS_THROUGH"}

    def _loaded(self, context: bpy.types.Context) -> set[str]:
        """Start the work that waited for its modules."""
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
        """Write for a moment, so that Blender can redraw before the next one; in the end report the outcome."""
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
        return outcome.run(self, lambda: self.finished(result))

    def cancel(self, context: bpy.types.Context) -> None:
        """Cancel the work; also called by Blender when its window closes."""
        self._run.stop()
        if self._slices is not None:
            self._slices.close()  # removes what is written already
        self._clear(context)

    def _show(self, context: bpy.types.Context) -> None:
        self._work.stage, self._work.share = self._run.stage, self._run.share
        percent = int(100 * self._run.share)
        context.window_manager.progress_update(percent)
        context.workspace.status_text_set(f"{self._work.label}: {self._run.stage} {percent} %   (Esc stops)")
        if self._ghost is not None:
            self._ghost.show(self._run.shown)
        _redraw(context)

    def _clear(self, context: bpy.types.Context) -> None:
        running_work.end()
        if self._ghost is not None:
            self._ghost.remove()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        _redraw(context)


def _escape(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Whether Esc is meant for this work: pressed, while no other modal tool, such as a move, can take it.

    The tool that is ended by Esc swallows the press but not the release, and may still be listed then.
    """
    if event.type != "ESC" or event.value != "PRESS":
        return False
    running = getattr(context.window, "modal_operators", ())
    return sum(not tool.bl_idname.startswith("SAMP_OT_") for tool in running) == 0


def _raise(error: BaseException) -> Callable[[], NoReturn]:
    def work() -> NoReturn:
        raise error

    return work


def _redraw(context: bpy.types.Context) -> None:
    """Redraw all 3D views and their sidebars."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type in {"WINDOW", "UI"}:
                        region.tag_redraw()
