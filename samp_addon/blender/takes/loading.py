"""What takes and refinements need, imported in a thread: the first time takes a second or two."""

from __future__ import annotations

from contextlib import suppress

from ...errors import SampError
from ...methods import registry
from ...progress import Progress
from ..thread_run import ThreadRun, one_slice


def begin(method: str = registry.DEFAULT) -> ThreadRun:
    """Start to load a method's networks. Where a package or a file is missing, the work that needs it reports that
    later."""

    def work(progress: Progress) -> None:
        progress("Loading", 0.0)
        with suppress(ImportError, OSError, SampError):
            from ..actions import refine_action  # noqa: F401
            from . import baking  # noqa: F401

            registry.find(method).load()

    return ThreadRun(work, lambda context, nothing: one_slice(lambda: None))
