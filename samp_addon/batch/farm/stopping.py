"""Stops a run by a signal: SIGTERM, with which farms cancel a task, and Ctrl+C."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_requested = threading.Event()


@contextmanager
def stoppable() -> Iterator[None]:
    """Raise KeyboardInterrupt inside the context where a signal asks for a stop; only in the main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _requested.clear()
    signals = [signal.SIGTERM]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signals.append(signal.SIGINT)
    before = {number: signal.signal(number, _stop) for number in signals}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _requested.clear()


def check() -> None:
    """Raise KeyboardInterrupt if a stop was asked for.

    Blender prints and drops exceptions in Python that it calls itself, as while it opens a file, so the exception of
    the signal handler may have been lost.
    """
    if _requested.is_set():
        raise KeyboardInterrupt


def _stop(*_: object) -> None:
    _requested.set()
    raise KeyboardInterrupt
