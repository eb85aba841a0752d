"""The networks are loaded while the artist still chooses: in a thread, from the first time that the tab is drawn."""

from __future__ import annotations

import bpy

from ...blender.takes import loading
from ...blender.thread_run import ThreadRun

_begun: dict[str, ThreadRun] = {}
"""By the name of a method."""


def begin(method: str, in_window: bool = not bpy.app.background) -> ThreadRun | None:
    """Return the thread that loads a method's networks, started the first time; None without a window."""
    if not in_window:
        return None
    if method not in _begun:
        _begun[method] = loading.begin(method)
    return _begun[method]
