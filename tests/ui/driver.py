"""Drives the sidebar of a Blender with a window by mouse and keyboard, under Xvfb with software GL.

python3 driver.py --blender blender --zip samp.zip --shots FOLDER

Needs Blender, Xvfb, xdotool and ImageMagick's import; only Python's standard library. Buttons are found by querying
Blender for the button under the mouse. The exit status is 0 if all steps succeed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

HERE = Path(__file__).resolve().parent
DISPLAY, WIDTH, HEIGHT = ":97", 1600, 1000
PORT = 47817
SCROLL = 4
"""Turns of the mouse wheel that move the sidebar by about half of its height."""

WHEEL_UP, WHEEL_DOWN = 4, 5
"""Buttons of the mouse."""

STEP = 15  # pixels between positions in the search for a button, less than its height
TOOLS = ("Xvfb", "xdotool", "import")


class Failure(Exception):
    """An expected result is missing."""


class Window:
    """A Blender with a window, and its mouse and keyboard."""

    def __init__(self, shots: Path) -> None:
        self.shots, self.count = shots, 0
        self.stream = None
        self.found: dict[str, tuple[int, int]] = {}

    def connect(self, seconds: float = 120.0) -> None:
        """Wait until Blender accepts a connection."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            with contextlib.suppress(OSError):
                connection = socket.create_connection(("127.0.0.1", PORT), timeout=300)
                self.stream = connection.makefile("rw")
                return
            time.sleep(0.5)
        raise Failure("Blender did not start")

    def ask(self, text: str) -> object:
        """Return the value of a Python expression in Blender."""
        self.stream.write(text + "\n")
        self.stream.flush()
        answer = json.loads(self.stream.readline())
        if "error" in answer:
            raise Failure(f"{text}: {answer['error']}")
        return answer["value"]

    def wait(self, text: str, wanted: Callable[[object], bool] = bool, seconds: float = 60.0) -> object:
        """Return the value of an expression as soon as ``wanted`` accepts it."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            value = self.ask(text)
            if wanted(value):
                return value
            time.sleep(0.1)
        raise Failure(f"waited {seconds:.0f} s for {text}, which is {value}")

    def shot(self, name: str) -> None:
        """Save a screenshot."""
        self.count += 1
        path = self.shots / f"{self.count:02d}_{name}.png"
        subprocess.run(["import", "-window", "root", str(path)], check=True)
        print(f"  picture {path.name}", flush=True)

    def key(self, keys: str) -> None:
        """Press keys."""
        subprocess.run(["xdotool", "key", keys], check=True)
        time.sleep(0.4)

    def move(self, x: int, y: int) -> None:
        """Move the mouse, in two steps, so that Blender receives a motion event."""
        subprocess.run(["xdotool", "mousemove", str(x + 2), str(y), "mousemove", str(x), str(y)], check=True)

    def click(self, x: int, y: int, button: int = 1) -> None:
        """Click at a position."""
        self.move(x, y)
        time.sleep(0.3)
        subprocess.run(["xdotool", "click", str(button)], check=True)
        time.sleep(0.4)

    def shift_click(self, x: int, y: int) -> None:
        """Click at a position with Shift held."""
        self.move(x, y)
        time.sleep(0.3)
        subprocess.run(["xdotool", "keydown", "shift", "sleep", "0.2", "click", "1"], check=True)
        time.sleep(0.4)
        subprocess.run(["xdotool", "keyup", "shift"], check=True)

    def drag(self, places: list[tuple[int, int]]) -> None:
        """Move the mouse with its button down from place to place, in small steps."""
        self.move(*places[0])
        time.sleep(0.3)
        subprocess.run(["xdotool", "mousedown", "1"], check=True)
        for (x, y), (to_x, to_y) in zip(places[:-1], places[1:], strict=True):
            for k in range(1, 9):
                at = x + (to_x - x) * k // 8, y + (to_y - y) * k // 8
                subprocess.run(["xdotool", "mousemove", str(at[0]), str(at[1])], check=True)
                time.sleep(0.06)
        subprocess.run(["xdotool", "mouseup", "1"], check=True)
        time.sleep(0.4)

    def find(self, text: str) -> tuple[int, int]:
        """Return the position of the button whose Python command or property path contains this text.

        The sidebar is searched as it is, then from its beginning to its end.
        """
        for turns, wheel in ((0, 0), (5 * SCROLL, WHEEL_UP), *4 * ((SCROLL, WHEEL_DOWN),)):
            left, top, _, height = self.ask("ui.sidebar_box()")
            for turn in range(turns):
                # At changing heights: a list under the mouse takes the wheel for itself.
                self.click(left + 40, top + height * (2 + turn % 3) // 6, wheel)
            place = self.visible(text)
            if place is not None:
                return place
        self.shot("not_found")
        raise Failure(f"no button '{text}' in the sidebar")

    def visible(self, text: str) -> tuple[int, int] | None:
        """Return the position of a button, or None where it is not seen."""
        left, top, width, height = self.ask("ui.sidebar_box()")
        known = self.found.get(text)
        if known is not None and any(text in self.under(*known) for _ in range(3)):
            return known
        for share in (0.42, 0.12, 0.93):
            for y in range(top + 30, min(top + height, HEIGHT) - 4, STEP):
                place = left + int(share * (width - 25)), y
                if text in self.under(*place):
                    self.found[text] = place
                    return place
        return None

    def under(self, x: int, y: int) -> str:
        """Return the command or property path of the button at a position."""
        self.move(x, y)
        time.sleep(0.09)
        return str(self.ask("ui.under_mouse()"))

    def press(self, text: str) -> None:
        """Click a button of the sidebar."""
        self.click(*self.find(text))


@contextlib.contextmanager
def display() -> Iterator[dict[str, str]]:
    """Run an X server with software GL; yield its environment variables."""
    runtime = tempfile.mkdtemp(prefix="xdg")
    environment = os.environ | {
        "DISPLAY": DISPLAY, "LIBGL_ALWAYS_SOFTWARE": "1", "XDG_RUNTIME_DIR": runtime, "PYTHONNOUSERSITE": "1",
    }  # fmt: skip
    os.environ.update(environment)
    command = [
        "Xvfb",
        DISPLAY,
        "-screen",
        "0",
        f"{WIDTH}x{HEIGHT}x24",
        "+extension",
        "GLX",
        "+render",
        "-noreset",
    ]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(2)
    try:
        yield environment
    finally:
        server.terminate()
        server.wait()
        shutil.rmtree(runtime, ignore_errors=True)


def prepare(blender: str, zip_file: Path, environment: dict[str, str]) -> None:
    """Install the extension with clean preferences, without splash and tooltips."""
    run = lambda *arguments: subprocess.run(
        [blender, *arguments], env=environment, check=True, capture_output=True
    )
    run("--command", "extension", "install-file", "-r", "user_default", "-e", str(zip_file))
    quiet = (
        "import bpy; p = bpy.context.preferences; p.view.show_splash = False; p.view.show_tooltips = False; "
        "p.view.show_developer_ui = True; p.use_preferences_save = False; bpy.ops.wm.save_userpref()"
    )
    run("-b", "--python-expr", quiet)


def main() -> int:
    """Run the tests and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--zip", type=Path, required=True)
    parser.add_argument("--shots", type=Path, required=True)
    options = parser.parse_args()
    missing = [tool for tool in (*TOOLS, options.blender) if shutil.which(tool) is None]
    if missing:
        print(f"test-ui: skipped, for {', '.join(missing)} is not installed here")
        return 0
    options.shots.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as user, display() as environment:
        own = environment | {"BLENDER_USER_RESOURCES": user, "HOME": user}
        prepare(options.blender, options.zip.resolve(), own)
        room = HERE.parents[1] / "demo" / "build_room.py"
        command = [options.blender, "-p", "0", "0", str(WIDTH), str(HEIGHT), "--python-exit-code", "1", "--python",
                   str(HERE / "inside.py"), "--", str(PORT), str(room)]  # fmt: skip
        with (options.shots / "blender.log").open("w") as log:
            process = subprocess.Popen(command, env=own, stdout=log, stderr=log)
            try:
                return run_story(Window(options.shots), Path(user))
            finally:
                process.kill()
                process.wait()


def run_story(window: Window, home: Path) -> int:
    """Run the steps and return the exit status."""
    sys.path.insert(0, str(HERE))
    from story import story

    window.connect()
    failed = 0  # steps after a failed one are not run
    for name, step in story(window, home):
        begun = time.monotonic()
        try:
            result = step()
            print(
                f"ok   {name} ({time.monotonic() - begun:.1f} s){f': {result}' if result else ''}", flush=True
            )
        except (Failure, subprocess.CalledProcessError, OSError) as error:
            print(f"FAIL {name}: {error}", flush=True)
            with contextlib.suppress(subprocess.CalledProcessError):
                window.shot("failed")
            failed += 1
            break
    print(f"test-ui: {'failed' if failed else 'passed'}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
