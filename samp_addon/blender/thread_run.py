"""Long work beside Blender's window: it goes on in a thread while the artist watches, and may stop it.

Only the thread's own arrays are touched there; reading and writing the scene happen where it is called from.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from contextlib import suppress
from typing import Any

import bpy

from ..errors import SampError
from ..motion import Motion
from ..progress import Progress

PATIENCE = 0.5  # seconds; an artist who stops something waits no longer


Slices = Generator[tuple[str, float], None, Any]
"""Work on the scene that lets Blender draw between its slices: yields stage and share done, returns what it made."""


def in_one_go(slices: Slices, progress: Progress = lambda stage, share: None) -> Any:
    """What the slices return in the end. Raises what they, or progress, raise."""
    try:
        while True:
            progress(*next(slices))
    except StopIteration as end:
        return end.value
    finally:
        slices.close()


def one_slice(work: Callable[[], Any]) -> Slices:
    """Work that is too short to be cut."""
    yield "Writing keyframes", 0.0
    return work()


class Cancelled(Exception):
    """Raised by a progress function to stop the work."""


def loading() -> ThreadRun:
    """What takes and refinements need, imported: the first time takes a second or two. Where something is missing,
    whoever needs it says so."""

    def work(progress: Progress) -> None:
        progress("Loading", 0.0)
        with suppress(ImportError, OSError):
            from ..pipeline import chain
            from .actions import refine_action  # noqa: F401

            chain.networks()

    return ThreadRun(work, lambda context, nothing: one_slice(lambda: None))


class ThreadRun:
    """Work in flight. Start it by making it; look at `done`, `stage`, `share` and `shown`; then `finish` it.

    shown: what there is to see so far, a single frame or a whole take, or None.
    """

    def __init__(
        self,
        work: Callable[[Progress], Any],
        write: Callable[[bpy.types.Context, Any], Slices],
        owner: bpy.types.Object | None = None,
    ) -> None:
        """Starts the thread. work: what it does, without Blender. write: what becomes of that in the scene.

        owner: the character that it is for, if there is one yet.
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
        """Whether there is something to finish."""
        return not self._thread.is_alive()

    def wait(self, seconds: float) -> bool:
        """Whether it is done, after waiting for it for that long at most."""
        self._thread.join(seconds)
        return self.done

    def stop(self) -> None:
        """Asks the thread to stop, and waits a moment until it has; whatever it still makes is thrown away."""
        self._stop.set()
        self._thread.join(PATIENCE)

    def finish(self, context: bpy.types.Context) -> Any:
        """What the slices of `finishing` return."""
        return in_one_go(self.finishing(context))

    def finishing(self, context: bpy.types.Context) -> Slices:
        """Writes what was made. Raises what the work raised, Cancelled if it was stopped, and SampError where the
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
        except BaseException as error:  # it is raised again where the artist sees it
            self._error = error

    def _present(self, context: bpy.types.Context) -> bool:
        """Whether the character is still there: an undo takes away what Python points to."""
        try:
            return self.owner is None or self.owner.name in context.scene.objects
        except ReferenceError:
            return False


class _Watch:
    """The thread's progress function, which the window looks at."""

    def __init__(self, run: ThreadRun) -> None:
        self._run = run

    def __call__(self, stage: str, share: float) -> None:
        self._run.stage, self._run.share = stage, share
        if self._run._stop.is_set():
            raise Cancelled

    def show(self, motion: Motion) -> None:
        self._run.shown = motion
