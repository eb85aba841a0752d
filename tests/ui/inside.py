"""Runs inside a Blender with a window: evaluates the requests of driver.py from a socket on Blender's main thread.

A request is a line of Python; its answer is one line of JSON. The name `ui` in it is the namespace of this file.
"""

import json
import queue
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import bpy
from mathutils import Vector

UI = SimpleNamespace()
PORT = int(sys.argv[sys.argv.index("--") + 1])
ROOM = Path(sys.argv[sys.argv.index("--") + 2])
draws: list[float] = []
_asked: queue.Queue = queue.Queue()


def main_area() -> tuple:
    """Return the window, and the largest 3D view with its main region and its sidebar."""
    window = bpy.context.window_manager.windows[0]
    area = max((a for a in window.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.width * a.height)
    regions = {region.type: region for region in area.regions}
    return window, area, regions["WINDOW"], regions["UI"]


def furnish() -> list[str]:
    """Build the demo's living room in an empty scene and set the view; return the names of its objects."""
    import bl_ext.user_default.samp as package

    sys.modules["samp_blender"] = package
    sys.path.insert(0, str(ROOM.parent))
    import build_room

    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    build_room.build(bpy.context.scene)
    for thing in bpy.context.scene.objects:
        if any(word in thing.name.lower() for word in ("wall", "ceiling", "window", "sky")):
            thing.hide_set(True)
    window, area, region, sidebar = main_area()
    space = area.spaces.active
    space.show_region_ui, space.show_region_toolbar = True, False
    space.shading.type = "SOLID"
    space.overlay.show_extras = True
    space.region_3d.view_perspective = "PERSP"
    space.region_3d.view_location, space.region_3d.view_distance = (0.0, 0.0, 0.6), 11.0
    space.region_3d.view_rotation = (0.78, 0.48, 0.21, 0.34)
    return sorted(thing.name for thing in bpy.context.scene.objects)


def look(at: tuple, distance: float, frame: int) -> None:
    """Aim the 3D view at a point from a distance in metres, in a frame."""
    space = main_area()[1].spaces.active.region_3d
    space.view_location, space.view_distance = at, distance
    bpy.context.scene.frame_set(frame)


def open_tab() -> None:
    """Show the tab SAMP."""
    main_area()[3].active_panel_category = "SAMP"
    main_area()[1].tag_redraw()


def sidebar_box() -> list[int]:
    """Return left, top, width and height of the sidebar in pixels of the window, from its top."""
    window, _, _, region = main_area()
    return [region.x, window.height - region.y - region.height, region.width, region.height]


def in_view(operator: Callable[..., set], **values: object) -> list[str]:
    """Run an operator as in the 3D view; return its result."""
    window, area, region, _ = main_area()
    with bpy.context.temp_override(window=window, area=area, region=region):
        return sorted(operator("EXEC_DEFAULT", **values))


def place_of(point: tuple) -> list[int]:
    """Return the window position, in pixels from the top left, of a point in the world."""
    from bpy_extras.view3d_utils import location_3d_to_region_2d

    window, area, region, _ = main_area()
    at = location_3d_to_region_2d(region, area.spaces.active.region_3d, point)
    return [round(region.x + at.x), round(window.height - region.y - at.y)]


def under_mouse() -> str:
    """Return the Python command of the button under the mouse, or its property path, or an empty string."""
    window, area, _, region = main_area()
    bpy.context.window_manager.clipboard = ""
    with bpy.context.temp_override(window=window, area=area, region=region):
        for operator in (bpy.ops.ui.copy_python_command_button, bpy.ops.ui.copy_data_path_button):
            try:
                if operator.poll() and operator() == {"FINISHED"}:
                    return bpy.context.window_manager.clipboard
            except RuntimeError:
                continue
    return ""


def tools() -> list[str]:
    """Return the modal operators of this add-on that run in the window."""
    window = main_area()[0]
    return [tool.bl_idname for tool in window.modal_operators if tool.bl_idname.startswith("SAMP_OT_")]


def top_of(thing: bpy.types.Object) -> list[float]:
    """Return the middle of the top of an object's box in the world."""
    corners = [thing.matrix_world @ Vector(corner) for corner in thing.bound_box]
    middle = sum(corners, Vector()) / len(corners)
    return [middle.x, middle.y, max(corner.z for corner in corners)]


def aimed() -> list | None:
    """Return action, target and whether a body fits of what Place shows, or None."""
    from bl_ext.user_default.samp.samp_addon.blender.placing import figure

    spot = figure.shown()
    return None if spot is None else [spot.action, spot.target, spot.fits, spot.reason]


def takes() -> list[str]:
    """Return the names of all takes."""
    return sorted(action.name for action in bpy.data.actions if "samp" in action)


def fingerprint() -> str:
    """Return the state that a cancelled run must not change."""
    places = [
        [thing.name, *map(float, (v for row in thing.matrix_world for v in row))]
        for thing in bpy.data.objects
    ]
    counts = [len(getattr(bpy.data, kind)) for kind in ("actions", "meshes", "armatures", "objects")]
    return json.dumps([places, counts])


def running() -> list | None:
    """Return name, stage and share of the running work, or None."""
    from bl_ext.user_default.samp.samp_addon.blender import running_work

    found = running_work.current()
    return None if found is None else [found.label, found.stage, found.share]


def actions_in(path: str) -> list[str]:
    """Return the names of the Actions in a saved file."""
    with bpy.data.libraries.load(path) as (found, _):
        return sorted(found.actions)


def panel_seconds() -> dict[str, float]:
    """Return the mean seconds to draw each panel since count_draws."""
    return {name: sum(times) / len(times) for name, times in _times.items() if times}


_times: dict[str, list[float]] = {}


def count_draws() -> None:
    """Start counting redraws of the 3D view and timing the panels."""
    from bl_ext.user_default.samp.samp_addon import ui

    if not _times:
        bpy.types.SpaceView3D.draw_handler_add(
            lambda: draws.append(time.monotonic()), (), "WINDOW", "POST_PIXEL"
        )
        for cls in ui._classes():
            if hasattr(cls, "bl_space_type"):
                _time(cls)
    draws.clear()


def _time(cls: type) -> None:
    inner, name = cls.draw, cls.__name__
    _times[name] = []

    def draw(self, context):  # noqa: ANN001, ANN202
        begun = time.perf_counter()
        inner(self, context)
        _times[name].append(time.perf_counter() - begun)

    bpy.utils.unregister_class(cls)
    cls.draw = draw
    bpy.utils.register_class(cls)


def redraw_seconds() -> float:
    """Return the seconds of one redraw of the idle window."""
    begun = time.monotonic()
    bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=10)
    return (time.monotonic() - begun) / 10


def draw_gap() -> list[float]:
    """Return the redraws since count_draws, the seconds from first to last, and the longest gap."""
    gaps = [b - a for a, b in zip(draws[:-1], draws[1:], strict=True)]
    return [len(draws), draws[-1] - draws[0] if draws else 0.0, max(gaps, default=0.0)]


def _serve() -> None:
    server = socket.create_server(("127.0.0.1", PORT))
    while True:
        connection, _ = server.accept()
        with connection, connection.makefile("rw") as stream:
            for line in stream:
                answer: queue.Queue = queue.Queue()
                _asked.put((line, answer))
                stream.write(answer.get() + "\n")
                stream.flush()


def _answer() -> float:
    while not _asked.empty():
        line, answer = _asked.get()
        try:
            result = {"value": eval(line, {"ui": UI, "bpy": bpy})}
        except Exception:
            result = {"error": traceback.format_exc()}
        answer.put(json.dumps(result, default=str))
    return 0.02


# Blender runs scripts as __main__, which is replaced afterwards.
vars(UI).update(globals())
threading.Thread(target=_serve, daemon=True).start()
bpy.app.timers.register(_answer, persistent=True)
