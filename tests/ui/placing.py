"""Place and Draw Path with a real mouse: what lights up, a click, steps, Esc, a drawn line."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driver import Window

PATIENCE = 600.0
"""Seconds, for software GL on two busy cores."""


class Placing:
    """Steps of the story in a room that is furnished and has a character."""

    def __init__(self, window: Window) -> None:
        self.window = window

    def _check(self, condition: bool, message: str) -> None:
        from driver import Failure

        if not condition:
            raise Failure(message)

    def _aim(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Start Place; return where the seat of the sofa and where the floor is in the window."""
        window = self.window
        window.ask("ui.look((0.6, 0.6, 0.6), 8.0, 1)")
        window.press("bpy.ops.samp.place")
        window.wait("'SAMP_OT_place' in ui.tools()")
        seat = "bpy.data.objects['Sofa Seat cushion']"
        top = window.ask(f"ui.top_of({seat})")
        return tuple(window.ask(f"ui.place_of({tuple(top)})")), tuple(
            window.ask("ui.place_of((-0.4, -1.6, 0))")
        )

    def place(self) -> str:
        window = self.window
        seat, floor = self._aim()
        window.move(*floor)
        window.wait("ui.aimed()", lambda spot: spot is not None and spot[0] == "walk")
        time.sleep(1.0)
        window.shot("place_floor")
        begun = time.monotonic()
        window.move(*seat)
        window.wait("ui.aimed()", lambda spot: spot is not None and spot[0] in ("sit", "lie") and spot[2])
        seconds = time.monotonic() - begun
        time.sleep(1.0)
        window.shot("place_seat")
        first = window.ask("ui.aimed()")
        window.click(*seat, button=5)
        time.sleep(1.0)
        window.shot("place_wheel")
        other = window.ask("ui.aimed()")
        window.click(*seat, button=4)
        before = window.ask("ui.takes()")
        window.click(*seat)
        window.wait(
            "(ui.running(), ui.takes())",
            lambda value: value[0] is None and len(value[1]) == len(before) + 1,
            PATIENCE,
        )
        window.shot("placed")
        self._check(not window.ask("ui.tools()"), "the tool goes on after the click")
        window.key("ctrl+z")
        window.wait("ui.takes()", lambda left: left == before)
        return f"{seconds:.2f} s to the highlight; {first} then {other}"

    def leave(self) -> None:
        window = self.window
        before, steps = window.ask("ui.fingerprint()"), window.ask("len(bpy.context.scene.samp.steps)")
        seat, _ = self._aim()
        window.move(*seat)
        window.wait("ui.aimed()", lambda spot: spot is not None and spot[2])
        window.shift_click(*seat)
        window.wait("len(bpy.context.scene.samp.steps)", lambda count: count == steps + 1)
        window.key("Escape")
        window.wait("ui.tools()", lambda tools: not tools)
        self._check(window.ask("ui.fingerprint()") == before, "the scene is not as it was")
        self._check(window.ask("len(bpy.context.scene.samp.steps)") == steps, "a step is left over")

    def draw_path(self) -> str:
        window = self.window
        window.press("bpy.ops.samp.draw_path")
        window.wait("'SAMP_OT_draw_path' in ui.tools()")
        places = [(-1.2, -2.2, 0), (-0.4, -1.6, 0), (0.6, -1.6, 0), (1.4, -2.0, 0)]
        window.drag([tuple(window.ask(f"ui.place_of({place})")) for place in places])
        count = "len([o for o in bpy.data.objects if 'samp_waypoint' in o])"
        made = window.wait(count)
        time.sleep(1.0)
        window.shot("drawn_path")
        x, y, width, height = window.ask("ui.sidebar_box()")
        window.move(x - 300, y + height // 2)
        window.key("ctrl+z")
        window.wait(count, lambda left: left == 0)
        return f"{made} way-points"
