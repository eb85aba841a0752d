"""A window for modal operators in background."""

from __future__ import annotations

import bpy


class Screen:
    """What a modal operator asks of Blender's window."""

    def __init__(self):
        self.timers, self.status, self.window, self.windows = [], None, None, []
        self.window_manager = self.workspace = self

    def __getattr__(self, name):
        return getattr(bpy.context, name)

    def event_timer_add(self, step, window):
        self.timers.append(step)
        return step

    def event_timer_remove(self, timer):
        self.timers.remove(timer)

    def status_text_set(self, text):
        self.status = text

    def progress_begin(self, low, high):
        pass

    progress_update = progress_end = modal_handler_add = lambda self, *_: None
