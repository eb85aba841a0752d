"""What takes and refinements need, imported in a thread: the first time takes a second or two."""

from __future__ import annotations

import threading
from contextlib import suppress

from ...errors import SampError
from ...methods import registry
from ...progress import Progress
from ..thread_run import ThreadRun, one_slice

_loading = threading.Lock()
"""Held by the thread that loads: a button pressed meanwhile waits for it, and does not read the same weights again."""


def begin(method: str | None = None) -> ThreadRun:
    """Start a thread that loads a method's networks, or those of the default method.

    Missing packages and damaged files are not reported here: the work that needs them does so.
    """

    def work(progress: Progress) -> None:
        progress("Loading", 0.0)
        with _loading, suppress(ImportError, OSError, SampError):
            from ..actions import refine_action  # noqa: F401
            from . import baking  # noqa: F401

            registry.find(method or registry.DEFAULT).load()

    return ThreadRun(work, lambda context, nothing: one_slice(lambda: None))
