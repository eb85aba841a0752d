"""Sub-goals on floor, sofa and floor; with a real mouse another body, a pin, Bake, and Clear Sub-goals."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driver import Window

PATIENCE = 600.0
"""Seconds, for software GL on two busy cores."""
FIRST, LAST = (-0.2, -2.4, 0), (1.2, -2.0, 0)
"""Where the character stands at first and at last."""
SUB_GOALS = "sorted(o.name for o in bpy.data.objects if 'samp_sub_goal_pose' in o)"
POSES = "[list(o['samp_sub_goal_pose']) for o in bpy.data.objects if 'samp_sub_goal_pose' in o]"


class Blocking:
    """Steps of the story in a room that is furnished and has a character."""

    def __init__(self, window: Window) -> None:
        self.window = window

    def _check(self, condition: bool, message: str) -> None:
        from driver import Failure

        if not condition:
            raise Failure(message)

    def _method(self, name: str) -> None:
        self.window.ask(f"setattr(bpy.context.scene.samp, 'method', {name!r})")
        time.sleep(1.0)

    def add(self) -> str:
        """Add a sub-goal at each of three places."""
        window = self.window
        self._method("long_term")
        window.ask("ui.look((0.4, -0.4, 0.6), 8.0, 1)")
        seat = tuple(window.ask("ui.top_of(bpy.data.objects['Sofa Seat cushion'])"))
        longest = 0.0
        for count, point in enumerate((FIRST, seat, LAST), start=1):
            begun = time.monotonic()
            window.ask(f"ui.in_view(bpy.ops.samp.add_sub_goal, location={tuple(point)})")
            window.wait(f"len({SUB_GOALS})", lambda found, count=count: found == count, PATIENCE)
            longest = max(longest, time.monotonic() - begun)
        actions = window.ask(
            "[o['samp_sub_goal_action'] for o in bpy.data.objects if 'samp_sub_goal_pose' in o]"
        )
        self._check(actions.count("sit") == 1, f"the bodies are {actions}")
        time.sleep(1.0)
        window.shot("sub_goals")
        return f"at most {longest:.1f} s for a body"

    def other_body(self) -> str:
        """Another Body draws the active one again; a pinned one stays."""
        window = self.window
        before = window.ask(POSES)
        begun = time.monotonic()
        window.press("bpy.ops.samp.sample_bodies")
        window.wait(POSES, lambda poses: poses != before, PATIENCE)
        seconds = time.monotonic() - begun
        window.press("bpy.ops.samp.pin_body")
        pinned = "[o.name for o in bpy.data.objects if o.get('samp_sub_goal_pinned')]"
        window.wait(f"len({pinned})", lambda count: count == 1)
        window.shot("pinned")
        return f"{seconds:.1f} s"

    def bake(self) -> str:
        """Bake passes the sub-goals; undo brings back what was."""
        window = self.window
        before = window.ask("ui.takes()")
        begun = time.monotonic()
        window.press("bpy.ops.samp.generate")
        window.wait(
            "(ui.running(), ui.takes())",
            lambda value: value[0] is None and len(value[1]) == len(before) + 1,
            PATIENCE,
        )
        seconds = time.monotonic() - begun
        last = window.ask("int(max(a.frame_range[1] for a in bpy.data.actions if 'samp' in a))")
        window.ask(f"ui.look((0.4, -0.4, 0.6), 8.0, {last // 4})")
        time.sleep(1.0)
        window.shot("blocked")
        x, y, width, height = window.ask("ui.sidebar_box()")
        window.move(x - 300, y + height // 2)
        window.key("ctrl+z")
        window.wait("ui.takes()", lambda left: left == before)
        return f"{seconds:.1f} s"

    def clear(self) -> None:
        """Clear Sub-goals leaves nothing behind."""
        window = self.window
        window.press("bpy.ops.samp.clear_sub_goals")
        window.wait(f"not {SUB_GOALS}")
        self._method("samp")
