"""A job beside Blender's window: the networks work in a thread while the artist watches, and may stop it.

Only the thread's own arrays are touched there; reading and writing the scene happen where it is called from.
"""

from __future__ import annotations

import threading

import bpy

from ..errors import SampError
from ..job import Job
from ..synthesis import chain
from . import jobs
from .jobs import Cancelled


class JobRun:
    """One job in flight. Start it by making it; look at `done`, `stage` and `share`; then `finish` it."""

    def __init__(self, context: bpy.types.Context, job: Job, tools: chain.Tools | None = None) -> None:
        """Reads the scene and starts the thread. Raises SampError where the job cannot be done."""
        self.plan = jobs.read(context, job)
        self.stage, self.share = "Starting", 0.0
        self._stop = threading.Event()
        self._made: tuple | None = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, args=(tools,), name="SAMP", daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether there is something to finish."""
        return not self._thread.is_alive()

    def stop(self) -> None:
        """Asks the thread to stop, and waits until it has. Nothing is left behind."""
        self._stop.set()
        self._thread.join()

    def finish(self, context: bpy.types.Context) -> jobs.Result:
        """Writes what was made. Raises SampError for a failed job, Cancelled for a stopped one."""
        self._thread.join()
        if self._stop.is_set():
            raise Cancelled
        if self._error is not None:
            raise self._error
        if not self._present(context):
            raise SampError("The character is gone since the take was begun; start again.")
        return jobs.write(context, self.plan, *self._made)

    def _work(self, tools: chain.Tools | None) -> None:
        try:
            self._made = jobs.synthesise(self.plan, self._progress, tools)
        except BaseException as error:  # it is raised again where the artist sees it
            self._error = error

    def _progress(self, stage: str, share: float) -> None:
        self.stage, self.share = stage, share
        if self._stop.is_set():
            raise Cancelled

    def _present(self, context: bpy.types.Context) -> bool:
        """Whether the character is still there: an undo takes away what Python points to."""
        try:
            return self.plan.owner is None or self.plan.owner.name in context.scene.objects
        except ReferenceError:
            return False
