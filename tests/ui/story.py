"""A first session in the sidebar, step by step; each step checks its result."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driver import Window

GOALS = 5  # arrows that Sample Goals draws
HEADERS = (46, 52, 58, 64)  # pixels from a button up to the header of the panel above
PATIENCE = 600.0  # seconds, for software GL on two busy cores


def story(window: Window, home: Path) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield names and steps in order. home: folder for saved files."""
    from blocking import Blocking
    from placing import Placing

    session, placing, blocking = _Session(window, home), Placing(window), Blocking(window)
    yield "the room and the tab", session.open
    yield "create a character", session.create
    yield "click the sofa", session.pick
    yield "Sit Here", session.sit
    yield "Sit Here again, and a save meanwhile", session.again
    yield "Esc stops", session.escape
    yield "the cancel button stops", session.cancel
    yield "star one, delete the other", session.keep
    yield "undo and redo", session.undo
    yield "Refine", session.refine
    yield "trails", session.trails
    yield "goals and path", session.places
    yield "Place", placing.place
    yield "Esc leaves Place", placing.leave
    yield "a path drawn on the floor", placing.draw_path
    yield "sub-goals", blocking.add
    yield "another body, pinned", blocking.other_body
    yield "a take through the sub-goals", blocking.bake
    yield "clear the sub-goals", blocking.clear
    yield "the right-click menu", session.menu
    yield "save and open again", session.save


class _Session:
    def __init__(self, window: Window, home: Path) -> None:
        self.window, self.home = window, home

    def _check(self, condition: bool, message: str) -> None:
        from driver import Failure

        if not condition:
            raise Failure(message)

    def open(self) -> None:
        window = self.window
        names = window.ask("ui.furnish()")
        self._check("Sofa" in names, f"the room has {names}")
        time.sleep(2)
        window.ask("ui.open_tab()")
        time.sleep(2)
        window.shot("tab")

    def create(self) -> None:
        self.window.press("bpy.ops.samp.create_character")
        self.window.wait("'Human' in bpy.data.objects")
        self.window.ask("setattr(bpy.data.objects['Human'], 'location', (-0.4, -2.2, 0))")
        self.window.shot("character")

    def pick(self) -> str:
        window = self.window
        seat = window.ask(
            "list(sum((c.matrix_world @ __import__('mathutils').Vector((0, 0, 0)) for c in "
            "bpy.data.objects['Sofa'].children if 'cushion' in c.name.lower()), "
            "__import__('mathutils').Vector()) / max(1, len([c for c in bpy.data.objects['Sofa'].children "
            "if 'cushion' in c.name.lower()])))"
        )
        window.click(*window.ask(f"ui.place_of({tuple(seat)})"))
        clicked = window.ask("bpy.context.view_layer.objects.active.name")
        whole = window.ask(
            "(lambda o: o.parent.name if o.parent else o.name)(bpy.context.view_layer.objects.active)"
        )
        self._check("Sofa" in (clicked, whole), f"the click met '{clicked}'")
        window.shot("sofa_clicked")
        return f"a redraw alone takes {1000 * window.ask('ui.redraw_seconds()'):.0f} ms"

    def sit(self) -> str:
        window = self.window
        place = window.find("bpy.ops.samp.generate")
        window.ask("ui.count_draws()")
        begun = time.monotonic()
        window.click(*place)
        window.wait("ui.running()", seconds=20)
        window.wait(
            "ui.running()", lambda value: value is None or value[1] == "Moving" and value[2] > 0.2, PATIENCE
        )
        window.shot("running")
        window.wait(
            "(ui.running(), ui.takes())", lambda value: value[0] is None and len(value[1]) == 1, PATIENCE
        )
        seconds, drawn = time.monotonic() - begun, self._drawn()
        window.shot("seated")
        return f"{seconds:.1f} s; {drawn}"

    def again(self) -> str:
        window = self.window
        window.ask("ui.count_draws()")
        begun = time.monotonic()
        window.press("bpy.ops.samp.generate")
        window.wait("ui.running()", lambda value: value is not None and value[1] == "Moving", PATIENCE)
        path = self.home / "meanwhile.blend"
        window.ask(f"str(bpy.ops.wm.save_as_mainfile(filepath={str(path)!r}, copy=True))")
        self._check(window.ask("ui.running()") is not None, "the save ended the run")
        self._check(path.is_file(), "nothing was saved")
        window.wait(
            "(ui.running(), ui.takes())", lambda value: value[0] is None and len(value[1]) == 2, PATIENCE
        )
        seconds, drawn = time.monotonic() - begun, self._drawn()
        inside = window.ask(f"ui.actions_in({str(path)!r})")
        self._check(len(inside) == 1, f"the file saved meanwhile holds {inside}")
        window.shot("again")
        return f"{seconds:.1f} s; {drawn}"

    def _drawn(self) -> str:
        draws, span, longest = self.window.ask("ui.draw_gap()")
        return f"{draws / max(span, 1e-6):.1f} redraws a second, the longest gap {longest:.2f} s"

    def _stopped(self, aimed: Callable[[], Callable[[], None]]) -> str:
        """Start a run, stop it, and return the time that took. aimed: locates the control and returns its action."""
        window = self.window
        window.ask("setattr(bpy.context.scene.samp, 'variants', 64)")  # longer than the search for a button
        before, place = window.ask("ui.fingerprint()"), window.find("bpy.ops.samp.generate")
        window.click(*place)
        window.wait("ui.running()", seconds=20)
        stop = aimed()
        begun = time.monotonic()
        stop()
        window.wait("ui.running() is None", seconds=10)
        seconds = time.monotonic() - begun
        self._check(window.ask("ui.fingerprint()") == before, "the scene is not as it was")
        window.ask("setattr(bpy.context.scene.samp, 'variants', 1)")
        return f"{seconds:.2f} s"

    def escape(self) -> str:
        return self._stopped(lambda: lambda: self.window.key("Escape"))

    def cancel(self) -> str:
        def aimed() -> Callable[[], None]:
            place = self.window.find("bpy.ops.samp.stop")
            return lambda: self.window.click(*place)

        return self._stopped(aimed)

    def keep(self) -> None:
        window = self.window
        first, second = window.ask("ui.takes()")
        window.press("bpy.ops.samp.star_take")
        starred = window.ask("[a.name for a in bpy.data.actions if a.get('samp_star')]")
        self._check(len(starred) == 1, f"starred are {starred}")
        window.press("unstarred=True")
        window.shot("asks")
        self._check(len(window.ask("ui.takes()")) == 2, "takes were deleted without asking")
        window.key("Return")
        window.wait("ui.takes()", lambda left: left == starred)
        window.shot("kept")

    def undo(self) -> None:
        window = self.window
        x, y, width, height = window.ask("ui.sidebar_box()")
        window.move(x - 300, y + height // 2)
        window.key("ctrl+z")
        window.wait("len(ui.takes())", lambda count: count == 2)
        window.key("ctrl+shift+z")
        window.wait("len(ui.takes())", lambda count: count == 1)

    def refine(self) -> str:
        window = self.window
        begun = time.monotonic()
        window.press("bpy.ops.samp.refine")
        window.wait("ui.running()", seconds=20)
        time.sleep(2)
        window.shot("refining")
        window.wait(
            "(ui.running(), ui.takes())", lambda value: value[0] is None and len(value[1]) == 2, PATIENCE
        )
        window.ask("ui.look((1.0, 1.6, 0.6), 6.0, 330)")
        time.sleep(1.5)
        window.shot("refined")
        return f"{time.monotonic() - begun:.1f} s"

    def trails(self) -> None:
        window = self.window
        before = window.ask("ui.redraw_seconds()")
        window.press("show_trails")
        window.wait("bpy.context.scene.samp.show_trails")
        time.sleep(2.0)
        window.shot("trails")
        shown = window.ask("ui.redraw_seconds()")
        self._check(shown < before + 0.5, f"a redraw takes {shown:.2f} s with trails, {before:.2f} s without")
        window.press("show_trails")
        window.wait("not bpy.context.scene.samp.show_trails")

    def _unfold(self, below: str, inside: str) -> None:
        """Click the header of the panel above a button's own until a button inside it is visible."""
        from driver import Failure

        x, y = self.window.find(below)
        for height in HEADERS:
            self.window.click(x, y - height)
            if self.window.visible(inside) is not None:
                return
        raise Failure(f"no panel with '{inside}' expands above '{below}'")

    def places(self) -> None:
        window = self.window
        self._unfold("bpy.ops.samp.refine", "bpy.ops.samp.sample_goals")
        window.ask("ui.look((0.6, 0.6, 0.6), 8.0, 1)")
        sofa = "bpy.data.objects['Sofa Seat cushion']"
        window.ask(f"bpy.context.view_layer.objects.__setattr__('active', {sofa})")
        window.press("bpy.ops.samp.sample_goals")
        window.wait(
            "len([o for o in bpy.data.objects if 'samp_goal_target' in o])", lambda count: count == GOALS
        )
        window.ask(f"[o.select_set(o == {sofa}) for o in bpy.context.scene.objects] and None")
        window.ask(f"bpy.context.view_layer.objects.__setattr__('active', {sofa})")
        window.press("bpy.ops.samp.plan_path")
        window.wait("'SAMP Path' in bpy.data.objects")
        time.sleep(1.0)
        window.shot("goals_and_path")
        window.press("bpy.ops.samp.clear_overlays()")
        window.wait("'SAMP Path' not in bpy.data.objects")

    def menu(self) -> None:
        window = self.window
        x, y, width, height = window.ask("ui.sidebar_box()")
        window.click(x - 500, y + height // 2, 3)
        time.sleep(1.0)
        window.shot("right_click")
        window.key("Escape")

    def save(self) -> str:
        window = self.window
        path = self.home / "saved.blend"
        takes = window.ask("ui.takes()")
        window.ask(f"str(bpy.ops.wm.save_as_mainfile(filepath={str(path)!r}))")
        window.ask(
            f"str(bpy.app.timers.register(lambda: bpy.ops.wm.open_mainfile(filepath={str(path)!r}) and None))"
        )
        time.sleep(4)
        self._check(window.ask("ui.takes()") == takes, "takes are lost")
        self._check(window.ask("bpy.context.scene.samp.seed") > 0, "the settings are lost")
        window.ask("ui.open_tab()")
        time.sleep(2)
        window.shot("reopened")
        times = window.ask("ui.panel_seconds()")
        return "panels draw in " + ", ".join(f"{name} {1e3 * value:.2f} ms" for name, value in times.items())
