"""Long work in a thread while Blender's window stays responsive; the artist watches, and can cancel it.

The thread touches its own arrays only; the scene is read and written in the main thread.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from typing import Any

import bpy

from ..errors import SampError
from ..motion import Motion
from ..progress import Progress

PATIENCE = 0.5  # seconds that a cancel waits for the thread at most


Slices = Generator[tuple[str, float], None, Any]
"""Work on the scene in slices, between which Blender can redraw: yields stage and share done, returns its result."""


def run_to_completion(slices: Slices, progress: Progress = lambda stage, share: None) -> Any:
    """Run all slices and return their result. Raise what they, or the progress callback, raise."""
    try:
        while True:
            progress(*next(slices))
    except StopIteration as end:
        return end.value
    finally:
        slices.close()


def one_slice(work: Callable[[], Any]) -> Slices:
    """Wrap work that is too short for several slices."""
    yield "Writing keyframes", 0.0
    return work()


class Cancelled(Exception):
    """Raised by a progress callback to stop the work."""


class ThreadRun:
    """Work in flight: constructing it starts it; poll `done`, `stage`, `share` and `shown`; then `finish` it.

    shown: the newest preview, a single frame or a whole take, or None.
    """

    def __init__(
        self,
        work: Callable[[Progress], Any],
        write: Callable[[bpy.types.Context, Any], Slices],
        owner: bpy.types.Object | None = None,
    ) -> None:
        """Start the thread.

        work: runs in the thread, without Blender. write: puts its result into the scene. owner: the character that it
        is for, if there is one yet.
        """
        self.stage, self.share = "Starting", 0.0
        self.shown: Motion | None = None
        self._write, self.owner = write, owner
        self._stop = threading.Event()
        self._made: Any = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, args=(work,), name="SAMP", daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether the thread has ended."""
        return not self._thread.is_alive()

    def wait(self, seconds: float) -> bool:
        """Wait for at most that long; return whether it is done."""
        self._thread.join(seconds)
        return self.done

    def stop(self) -> None:
        """Ask the thread to stop and wait briefly for it; its result is discarded."""
        self._stop.set()
        self._thread.join(PATIENCE)

    def finish(self, context: bpy.types.Context) -> Any:
        """Run `finishing` to its end and return its result."""
        return run_to_completion(self.finishing(context))

    def finishing(self, context: bpy.types.Context) -> Slices:
        """Write the result, in slices. Raise what the work raised, Cancelled if it was stopped, and SampError where the
        character is gone."""
        self._thread.join()
        if self._stop.is_set():
            raise Cancelled
        if self._error is not None:
            raise self._error
        slices = self._write(context, self._made)
        try:
            while True:
                if not self._present(context):
                    raise SampError("The character is gone since the work was begun; start again.")
                yield next(slices)
        except StopIteration as end:
            return end.value
        finally:
            slices.close()

    def _work(self, work: Callable[[Progress], Any]) -> None:
        try:
            self._made = work(_Watch(self))
        except BaseException as error:  # raised again in the main thread
            self._error = error

    def _present(self, context: bpy.types.Context) -> bool:
        """Whether the character still exists: an undo invalidates Python's references."""
        try:
            return self.owner is None or self.owner.name in context.scene.objects
        except ReferenceError:
            return False


class _Watch:
    """The thread's progress callback, polled by the window."""

    def __init__(self, run: ThreadRun) -> None:
        self._run = run

    def __call__(self, stage: str, share: float) -> None:
        self._run.stage, self._run.share = stage, share
        if self._run._stop.is_set():
            raise Cancelled

    def show(self, motion: Motion) -> None:
        self._run.shown = motion
