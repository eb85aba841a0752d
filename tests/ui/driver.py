"""The sidebar in a real Blender: real mouse clicks on real buttons, under Xvfb with software GL.

python3 driver.py --blender blender --zip samp.zip --shots FOLDER

Needs Xvfb, xdotool and ImageMagick's import beside Blender; nothing but Python's own library. Buttons are found by
what Blender says is under the mouse. Ends with 0 if everything a stranger does works.
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
STEP = 9  # pixels between two places at which a button is looked for
TOOLS = ("Xvfb", "xdotool", "import")


class Failure(Exception):
    """Something that a stranger expects did not happen."""


class Window:
    """A Blender with a window, and somebody at its mouse and keyboard."""

    def __init__(self, shots: Path) -> None:
        self.shots, self.count = shots, 0
        self.stream = None
        self.found: dict[str, tuple[int, int]] = {}

    def connect(self, seconds: float = 120.0) -> None:
        """Waits until Blender answers."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            with contextlib.suppress(OSError):
                connection = socket.create_connection(("127.0.0.1", PORT), timeout=300)
                self.stream = connection.makefile("rw")
                return
            time.sleep(0.5)
        raise Failure("Blender did not start")

    def ask(self, text: str) -> object:
        """The value of a Python expression in Blender."""
        self.stream.write(text + "\n")
        self.stream.flush()
        told = json.loads(self.stream.readline())
        if "error" in told:
            raise Failure(f"{text}: {told['error']}")
        return told["value"]

    def wait(self, text: str, wanted: Callable[[object], bool] = bool, seconds: float = 60.0) -> object:
        """The value of an expression as soon as it is what is wanted."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            value = self.ask(text)
            if wanted(value):
                return value
            time.sleep(0.1)
        raise Failure(f"waited {seconds:.0f} s for {text}, which is {value}")

    def shot(self, name: str) -> None:
        """A picture of the whole window."""
        self.count += 1
        path = self.shots / f"{self.count:02d}_{name}.png"
        subprocess.run(["import", "-window", "root", str(path)], check=True)
        print(f"  picture {path.name}", flush=True)

    def key(self, keys: str) -> None:
        """Presses keys."""
        subprocess.run(["xdotool", "key", keys], check=True)
        time.sleep(0.4)

    def move(self, x: int, y: int) -> None:
        """Moves the mouse; twice, for Blender looks at what has moved."""
        subprocess.run(["xdotool", "mousemove", str(x + 2), str(y), "mousemove", str(x), str(y)], check=True)

    def click(self, x: int, y: int, button: int = 1) -> None:
        """A real click."""
        self.move(x, y)
        time.sleep(0.3)
        subprocess.run(["xdotool", "click", str(button)], check=True)
        time.sleep(0.4)

    def find(self, text: str) -> tuple[int, int]:
        """Where in the sidebar the button is whose Python or property path holds this text."""
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
        self.shot("not_found")
        raise Failure(f"no button '{text}' in the sidebar")

    def under(self, x: int, y: int) -> str:
        """What is under the mouse at a place."""
        self.move(x, y)
        time.sleep(0.09)
        return str(self.ask("ui.under_mouse()"))

    def press(self, text: str) -> None:
        """Clicks a button of the sidebar."""
        self.click(*self.find(text))


@contextlib.contextmanager
def display() -> Iterator[dict[str, str]]:
    """An X server with software GL; yields the environment for it."""
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
    """Clean preferences with the extension installed, without splash and tooltips."""
    run = lambda *told: subprocess.run([blender, *told], env=environment, check=True, capture_output=True)
    run("--command", "extension", "install-file", "-r", "user_default", "-e", str(zip_file))
    quiet = (
        "import bpy; p = bpy.context.preferences; p.view.show_splash = False; p.view.show_tooltips = False; "
        "p.view.show_developer_ui = True; p.use_preferences_save = False; bpy.ops.wm.save_userpref()"
    )
    run("-b", "--python-expr", quiet)


def main() -> int:
    """The exit status."""
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
                return tell(Window(options.shots), Path(user))
            finally:
                process.kill()
                process.wait()


def tell(window: Window, home: Path) -> int:
    """Goes through the story; the exit status."""
    sys.path.insert(0, str(HERE))
    from story import story

    window.connect()
    failed = 0  # what follows a step that failed would fail as well
    for name, step in story(window, home):
        begun = time.monotonic()
        try:
            told = step()
            print(f"ok   {name} ({time.monotonic() - begun:.1f} s){f': {told}' if told else ''}", flush=True)
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
