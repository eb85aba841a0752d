"""Edits of a take by its menu, with a real mouse: each makes a take of its own, which undo takes back."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driver import Window

PATIENCE = 600.0
"""Seconds, for software GL on two busy cores."""
MENU = "SAMP_MT_edit_take"


class Editing:
    """Steps of the story in a room whose character has takes."""

    def __init__(self, window: Window) -> None:
        self.window = window

    def _check(self, condition: bool, message: str) -> None:
        from driver import Failure

        if not condition:
            raise Failure(message)

    def _chosen(self, entry: str) -> None:
        """Open the menu of the take and press the key of an entry."""
        window = self.window
        window.press(MENU)
        time.sleep(0.8)
        window.key(entry)

    def _edit(self, entry: str, confirms: bool) -> float:
        """Do one edit; return its seconds. The new take is taken back afterwards."""
        window = self.window
        before = window.ask("ui.takes()")
        self._chosen(entry)
        if confirms:
            time.sleep(0.8)
            window.key("Return")
        begun = time.monotonic()
        window.wait(
            "(ui.running(), ui.takes())",
            lambda value: value[0] is None and len(value[1]) == len(before) + 1,
            PATIENCE,
        )
        seconds = time.monotonic() - begun
        x, y, width, height = window.ask("ui.sidebar_box()")
        window.move(x - 300, y + height // 2)
        window.key("ctrl+z")
        window.wait("ui.takes()", lambda left: left == before)
        return seconds
