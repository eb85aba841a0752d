"""The one piece of work that runs beside Blender's window, for the operator, the panel and the Cancel button."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class RunningWork:
    """Work in flight. label, operator: text and operator of the button that was pressed. stage, share: its progress."""

    label: str
    operator: str = ""
    stage: str = "Loading"
    share: float = 0.0
    cancel_requested: bool = False


_current: RunningWork | None = None


def current() -> RunningWork | None:
    """Return the work that runs now, or None."""
    return _current


def begin(label: str, operator: str = "") -> RunningWork:
    """Register new work. There is never a second one: operators check `current` in their poll."""
    global _current  # noqa: PLW0603 (the window has one piece of work at a time)
    _current = RunningWork(label, operator)
    return _current


def end() -> None:
    """Unregister the work."""
    global _current  # noqa: PLW0603
    _current = None


def request_cancel() -> None:
    """Cancel the work that runs now, with its next tick."""
    if _current is not None:
        _current.cancel_requested = True
