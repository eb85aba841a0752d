"""Networks are loaded in a thread from the first drawing of the tab on; the first take does not wait for them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from ...blender.thread_run import ThreadRun

_begun: dict[str, ThreadRun] = {}
"""The loading threads, by the names of methods; read and written in the main thread only."""


def begin(method: str, in_window: bool = not bpy.app.background) -> ThreadRun | None:
    """Return the thread that loads a method's networks, started by the first call; None without a window.

    in_window: whether Blender has a window; in background mode nothing is loaded before it is needed.
    """
    if not in_window:
        return None
    if method not in _begun:
        from ...blender.takes import loading  # not at registration

        _begun[method] = loading.begin(method)
    return _begun[method]
