"""Parts of the table in tests/operators/test_faults.py: a room, faults in it, and the allowed outcomes."""

from __future__ import annotations

import contextlib
import io
import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import fakes
import fingerprint
import numpy as np
import rooms
from samp_blender.samp_addon.batch import main
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.takes import baking, measure
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline.job import Job

# Paths that baking a take may change: the character's pose and its active Action.
TAKE = (
    r"objects/{0}\.animation_data",
    r"objects/{0}\.pose\.bones\[.*\]\.(location|rotation_\w+|scale|bbone_\w+)",
    r"actions/[^/]*\.use_fake_user",
    r"scenes/[^/]*\.samp\.(take_index|seed|character)",
)
FORBIDDEN = re.compile(
    r'Traceback|Error|Exception|File "|line \d|None|nan\b|\bbpy\b|NoneType|numpy|unexpected'
)
ADVICE = (
    *(
        "choose",
        "select",
        "click",
        "name",
        "show",
        "unhide",
        "add",
        "create",
        "set",
        "give",
        "apply",
        "leave",
        "use",
        "correct",
        "generate",
    ),
    *("install", "start again", "try", "move", "turn", "delete", "mend", "make", "check", "go to", "switch"),
    *("parent", "say", "ask", "close", "save", "scale", "free", "open", "keep", "stop", "put", "unlock"),
)


@dataclass
class Room:
    """The scene of a case. sofa, owner: objects by role. files: an empty folder."""

    files: Path
    start: tuple[float, ...]

    @property
    def scene(self) -> bpy.types.Scene:
        return bpy.context.scene

    @property
    def sofa(self) -> bpy.types.Object:
        return bpy.data.objects["Sofa"]

    @property
    def owner(self) -> bpy.types.Object:
        return bpy.data.objects["Human"]


Press = Callable[[Room], object]


@dataclass(frozen=True)
class Case:
    """One row. message: pattern of the expected error; None for success. check: further assertions on success.
    owner: name of the character. changes: patterns of further paths that may change. networks: use the real ones."""

    name: str
    arrange: Press
    message: str | None = None
    press: Press | None = None
    check: Press | None = None
    owner: str | None = "Human"
    changes: tuple[str, ...] = ()
    networks: bool = False

    def run(self, room: Room) -> None:
        """Arrange, press, and check the outcome."""
        self.arrange(room)
        bpy.context.view_layer.update()
        before, unused = fingerprint.taken(), fingerprint.orphans()
        sentence = outcome(lambda: (self.press or sit)(room))
        after = fingerprint.taken()
        if self.message is not None:
            assert sentence is not None, f"succeeds, but should report '{self.message}'"
            assert_clear(sentence)
            assert re.search(self.message, sentence), sentence
            changed = fingerprint.differences(before, after, self.changes, additions=False)
            assert not changed, "\n".join(changed[:20])
            return
        assert sentence is None, sentence
        take = [pattern.format(re.escape(self.owner)) for pattern in TAKE] if self.owner else []
        changed = fingerprint.differences(before, after, (*take, *self.changes))
        assert not changed, "\n".join(changed[:20])
        assert fingerprint.orphans() <= unused, fingerprint.orphans() - unused
        if self.check is not None:
            self.check(room)


def build(path: Path) -> tuple[float, ...]:
    """Save a room with a sofa, four other pieces and a human; return the human's location and yaw."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = 30, 1.0
    start = rooms.to_blender(rooms.random_room(1, rooms.sofa), scene)
    bpy.context.view_layer.update()
    character.create_character(bpy.context, location=tuple(start[:3]), yaw=1.0)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return tuple(start)


def outcome(press: Callable[[], object]) -> str | None:
    """Return the error message of a press, or None on success."""
    try:
        result = press()
    except (RuntimeError, SampError) as error:
        text, polls = re.subn(r"^Operator bpy\.ops\.samp\.\w+\.poll\(\) ", "", str(error).strip())
        if polls:  # A tooltip has no full stop in Blender; an error has one.
            assert not text.endswith("."), text
            text += "."
        return text.removeprefix("Error: ")
    assert result in (None, {"FINISHED"}), result
    return None


def assert_clear(sentence: str) -> None:
    """Assert that a message is one sentence for artists that says what to do."""
    assert "\n" not in sentence, sentence
    without_names = re.sub(r"'.*?'(?!\w)", "''", sentence)
    assert not FORBIDDEN.search(without_names), sentence
    assert re.match(r"['\"A-Z-]", sentence), sentence
    assert len(sentence) < 400, sentence
    assert any(re.search(rf"\b{verb}\b", without_names, re.IGNORECASE) for verb in ADVICE), sentence
    assert sentence.endswith("."), sentence


# ------------------------------------------------------------------------------- to press


def sit(room: Room, **options: object) -> object:
    """Press Sit Here on the sofa and check the take."""
    result = bpy.ops.samp.sit_here("EXEC_DEFAULT", True, **({"target": "Sofa"} | options))
    if result == {"FINISHED"}:
        arrived()
    return result


def lie(room: Room, **options: object) -> object:
    """Press Lie Here on the sofa."""
    return bpy.ops.samp.lie_here("EXEC_DEFAULT", True, **({"target": "Sofa"} | options))


def press(operator: str, **options: object) -> Press:
    """Return a press of another operator."""
    return lambda room: getattr(bpy.ops.samp, operator)("EXEC_DEFAULT", True, **options)


def seated_on(target: str, **options: object) -> Press:
    """Return a press of Sit Here on another target."""
    return lambda room: sit(room, target=target, **options)


def arrived() -> None:
    """Assert that the active character's take ends at its goal, as evaluated by Blender."""
    _, numbers = measure.measure_take(bpy.context)
    assert numbers["success"] is True and numbers["position_error_cm"] < 5, numbers


def nothing(room: Room) -> None:
    """Leave the room unchanged."""


def both(*steps: Press) -> Press:
    """Return the steps combined, in order."""

    def arrange(room: Room) -> None:
        for step in steps:
            step(room)

    return arrange


def meanwhile(change: Press, job: Job | None = None, tools: object = None) -> Press:
    """Return a press of Sit Here in a thread, with a change by the artist before it is finished."""

    def go(room: Room) -> None:
        run = baking.begin(bpy.context, job or Job(action="sit", target="Sofa"), tools or fakes.TOOLS)
        wait(run)
        change(room)
        run.finish(bpy.context)

    return go


def wait(run: object) -> None:
    """Wait until a thread is done."""
    deadline = time.time() + 60
    while not run.done and time.time() < deadline:
        time.sleep(0.01)
    assert run.done


def bake_batch(room: Room, **options: object) -> None:
    """Run the batch in this process on room.blend. Raise SampError with its error output."""
    values = {"scene": room.files / "room.blend", "action": "sit", "target": "Sofa"} | options
    arguments = [text for name, value in values.items() for text in (f"--{name}", str(value))]
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors):
        status = main.main(arguments, tools=fakes.TOOLS)
    lines = [line.removeprefix("bake: ") for line in errors.getvalue().splitlines()]
    if status != main.DONE:
        raise SampError("\n".join(lines))
    assert not lines


def with_take(room: Room, frames: int = 40, name: str = "Old") -> bpy.types.Action:
    """Give the human an Action in which it sways."""
    start = np.array([room.start[0], 0.93, -room.start[1]])
    at = np.arange(frames) / 30
    root = start + np.stack([0.05 * np.sin(at), 0 * at, 0 * at], axis=1)
    still = np.tile([1.0, 0, 0, 0], (frames, 22, 1))
    return keyframes.write_motion(room.owner, Motion(root, still), name)


def activate(obj: bpy.types.Object | None) -> None:
    """Select and activate an object, or nothing."""
    for other in bpy.context.selected_objects:
        other.select_set(False)
    if obj is not None:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = obj


def add(kind: str, name: str, data: object = None, at: tuple = (0, 0, 0)) -> bpy.types.Object:
    """Add an object to the scene. kind: collection of bpy.data for its data, or '' for an empty."""
    if kind and data is None:
        data = getattr(bpy.data, kind).new(name)
    made = bpy.data.objects.new(name, data)
    made.location = at
    bpy.context.scene.collection.objects.link(made)
    return made
