"""Random sequences of operators, undo and redo, reproducible by seed."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy
import fakes
import fingerprint
import numpy as np
import rooms
from samp_blender.operators import OPERATORS, operator_class
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.actions import keyframes, notes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.motion import Motion

# Operators that need work in progress.
EXCLUDED = {"stop"}
OBJECTS = ("Human", "Sofa", "Bed", "Goal sit Sofa", None)
DRAGGED = ("Goal sit Sofa", "Goal lie Bed", "Way-point 1", "Way-point 2")
# Paths of the artist's data that may change: the character's pose and Action, selection, and the scene's settings.
MAY_CHANGE = (
    r"objects/Human\.(mode|animation_data|pose\.bones)",
    r"objects/Human\[custom\]",
    r"objects/Human mesh(\[custom\]|\.modifiers)",  # a control rig deforms the mesh in place of the character
    r"actions/.*use_fake_user",
    r".*\.shown/|.*\.active|context\.",
    r"scenes/.*(layer_collection|\.cursor|\.samp\.)",
    r"scenes/.*\.frame_(start|end|current|current_final|float|subframe|preview_.*)",  # Fit Frame Range
    r"objects/(Floor|Sofa|Bed)\[custom\]",  # Soft Seat
)
Step = tuple[str, dict]


def build() -> None:
    """Build a small room, a human with an Action by the artist, and a selected sofa."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    for name, boxes in (
        ("Floor", [((-2.5, -0.1, -2.5), (2.5, 0, 2.5))]),
        ("Sofa", [((-1, 0, -2), (1, 0.43, -1.2)), ((-1, 0.43, -2), (1, 0.8, -1.8))]),
        ("Bed", [((-2.2, 0, 0), (-1, 0.5, 2.1))]),
    ):
        corners = np.concatenate([rooms.box(*box) for box in boxes]).reshape(-1, 3)
        mesh = bpy.data.meshes.new(name)
        faces = np.arange(len(corners)).reshape(-1, 3)
        mesh.from_pydata([(x, -z, y) for x, y, z in corners.tolist()], [], faces.tolist())
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    scene.camera.location, scene.camera.rotation_euler = (2.2, -2.2, 1.8), (1.25, 0, 0.785)
    owner = character.create_character(bpy.context, location=(1.5, -1.5, 0))
    still = np.tile([1.0, 0, 0, 0], (20, 22, 1))
    root = np.tile([1.5, 0.93, 1.5], (20, 1))
    mine = keyframes.write_motion(owner, Motion(root, still), "Mine", scene=scene, activate=False)
    del mine[notes.MOTION_KEY]  # keyed by the artist: not a take
    compat.assign(owner, mine)
    click("Sofa")


def click(name: str | None) -> None:
    """Select and activate one object, or nothing."""
    for thing in bpy.context.selected_objects:
        thing.select_set(False)
    thing = bpy.data.objects.get(name) if name else None
    bpy.context.view_layer.objects.active = thing
    if thing is not None:
        thing.select_set(True)


def drag(name: str, by: Sequence[float]) -> None:
    """Move an arrow or a way-point, if it is there, as the artist does. by: (3,) metres."""
    thing = bpy.data.objects.get(name)
    if thing is not None:
        thing.location = [a + b for a, b in zip(thing.location, by, strict=True)]
        bpy.context.view_layer.update()


def options(name: str, rng: random.Random, files: Path) -> dict:
    """Return random options of an operator, sometimes invalid ones."""
    if name == "add_sub_goal":
        return {
            "location": rng.choice(((0.5, 0.5, 0.0), (0.3, 1.5, 0.43), (-1.6, -1.0, 0.5), (0.0, 0.0, 1.5)))
        }
    if name == "move_sub_goal":
        return {"direction": rng.choice(("UP", "DOWN"))}
    target = rng.choice(("Sofa", "Sofa", "Bed", "Floor", "Nothing", ""))
    job = {"seed": rng.randrange(9), "hold": rng.choice((0.0, 1.0)), "variants": rng.choice((1, 1, 2))}
    place = (rng.uniform(-3, 3), rng.uniform(-3, 3), 0.0)
    known = {
        "sit_here": {"target": target, **job},
        "lie_here": {"target": target, **job},
        "walk_here": {"location": place, "run": rng.random() < 0.5, **job},
        "voxelise": {"target": target},
        "sample_goals": {"target": target, "count": rng.randrange(1, 4)},
        "plan_path": {"target": target, "to_cursor": rng.random() < 0.5},
        "build_navmesh": {"cell": 0.1},
        "create_character": {"location": place, "name": rng.choice(("Human", "Eva"))},
        "bake": {"filepath": str(files / "take.npz"), "character": rng.choice(("", "Human", "Nobody"))},
        "export_npz": {"filepath": str(files / "take.npz")},
        "refine": {"strength": rng.random(), "character": rng.choice(("", "Human"))},
        "set_cushion": {"depth": rng.uniform(0, 0.1)},
        "measure": {"character": rng.choice(("", "Human"))},
        "edit_chain": {"change": rng.choice(("ADD", "ADD", "REMOVE", "UP", "DOWN"))},
        "delete_take": {"unstarred": rng.random() < 0.5},
        "show_take": {"action_name": rng.choice(("", "sit Sofa 0", "Mine")), "fit": rng.random() < 0.3},
        "clear_overlays": {"what": rng.choice(("ALL", "GOALS", "WAYPOINTS", "PICTURES"))},
        "hand_target": {
            "target": rng.choice(("Sofa", "Bed", "Human", "Nothing", "")),
            "hand": rng.choice(("left", "right")),
            "grasp": rng.random() < 0.3,
        },
        "blend_take": {"other": rng.choice(("Mine", "sit Sofa 0", "Nothing")), "frames": rng.choice((1, 8))},
        "redo_from_here": {"use_frame": True, "frame": rng.randrange(1, 60)},
        "place": {
            "location": rng.choice(((0, 1.6, 0.43), (-1.6, -1.0, 0.5), (*place[:2], 0.0), (0, 0, 9.0))),
            "choice": rng.randrange(3),
            "add_step": rng.random() < 0.3,
        },
        "improvise": {"seconds": 1.0, "draws": 1, "seed": rng.randrange(3)},
        "look_at": {"target": rng.choice(("Sofa", "Human", "Camera", "Nothing", "")), "ease": rng.random()},
        "retime_take": {name: rng.choice((0.7, 1.0, 1.4)) for name in ("walk", "settle", "hold")},
        "loop_take": {"in_place": rng.random() < 0.5},
        "reduce_keys": {"distance": rng.choice((0.001, 0.01)), "angle": rng.choice((0.1, 1.0))},
        "save_asset": {"directory": str(files), "what": rng.choice(("TAKE", "CHARACTER"))},
        "mark_take": {"phases": rng.random() < 0.7, "steps": rng.random() < 0.5},
        "edit_cast": {"change": rng.choice(("ADD", "ADD", "REMOVE"))},
        "step_take": {"direction": rng.choice(("NEXT", "PREVIOUS"))},
        "export_take": {"filepath": str(files / "take"), "kind": rng.choice(("NPZ", "FBX", "BVH"))},
    }
    return known.get(name, {})


def sequence(
    seed: int,
    length: int,
    files: Path,
    names: Sequence[str] = OPERATORS,
    objects: Sequence[str | None] = OBJECTS,
    dragged: Sequence[str] = DRAGGED,
) -> list[Step]:
    """Return the steps of a seed. names: operators to choose from. objects: what is clicked. dragged: what is moved."""
    rng = random.Random(seed)
    names = [name for name in names if name not in EXCLUDED]
    steps: list[Step] = []
    for _ in range(length):
        kind = rng.choices(("press", "undo", "redo", "click", "mode", "drag"), (8, 5, 3, 3, 1, 1))[0]
        if kind == "press":
            name = rng.choice(names)
            steps.append((name, options(name, rng, files)))
        elif kind == "click":
            steps.append((kind, {"name": rng.choice(objects)}))
        elif kind == "drag":
            by = (rng.uniform(-0.4, 0.4), rng.uniform(-0.2, 0.2), 0.0)
            steps.append((kind, {"name": rng.choice(dragged), "by": by}))
        else:
            steps.append((kind, {}))
    return steps


class User:
    """Runs a sequence and compares the file with each step of its undo history."""

    def __init__(self) -> None:
        build()
        bpy.context.preferences.edit.use_global_undo = True
        bpy.ops.ed.undo_push(message="begin")
        self.unused = fingerprint.orphans()
        self.first = fingerprint.taken()
        self.history, self.now = [self.first], 0

    def do(self, step: Step) -> None:
        """Run one step and check the file after it."""
        name, arguments = step
        own: dict[str, Callable[[], None]] = {
            "undo": lambda: self._travel(-1),
            "redo": lambda: self._travel(1),
        }
        if name in own:
            own[name]()
            return
        if name in {"click", "drag"}:
            {"click": click, "drag": drag}[name](**arguments)
            self._push()
        elif name == "mode":
            self._change_mode()
        else:
            self._press(name, arguments)
        lost = fingerprint.differences(self.first, fingerprint.taken(), MAY_CHANGE)
        assert not lost, lost
        assert fingerprint.orphans() <= self.unused, fingerprint.orphans() - self.unused

    def _press(self, name: str, arguments: dict) -> None:
        operator = getattr(bpy.ops.samp, name)
        if not operator.poll():
            return
        before = fingerprint.taken()
        try:
            done = operator("EXEC_DEFAULT", True, **arguments)
        except RuntimeError as error:
            text = str(error).strip()
            assert "Traceback" not in text and "\n" not in text and text.endswith("."), text
            done = {"CANCELLED"}
        if done == {"FINISHED"} and "UNDO" in operator_class(name).bl_options:
            self._note()
        else:
            changed = fingerprint.differences(before, fingerprint.taken(), additions=False)
            assert not changed, changed

    def _change_mode(self) -> None:
        active = bpy.context.view_layer.objects.active
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set("EXEC_DEFAULT", False, mode="OBJECT")
        elif active is not None and active.type == "ARMATURE":
            bpy.ops.object.mode_set("EXEC_DEFAULT", False, mode="POSE")
        self._push()

    def _push(self) -> None:
        bpy.ops.ed.undo_push(message="the artist's")
        self._note()

    def _note(self) -> None:
        self.history[self.now + 1 :] = [fingerprint.taken()]
        self.now += 1

    def _travel(self, by: int) -> None:
        """Undo or redo, and check that the file is exactly as it was at that step."""
        if not 0 <= self.now + by < len(self.history):
            return
        (bpy.ops.ed.undo if by < 0 else bpy.ops.ed.redo)()
        self.now += by
        changed = fingerprint.differences(self.history[self.now], fingerprint.taken(), additions=False)
        assert not changed, changed


def replace_networks(patch: object) -> None:
    """Replace the networks and the optimiser by fakes. patch: pytest's monkeypatch."""
    from samp_blender.samp_addon.methods.samp import goals, networks
    from samp_blender.samp_addon.refine import refinement as optimiser

    patch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    patch.setattr(goals, "sample_goals", fakes.sample_goals)
    patch.setattr(optimiser, "refine", fakes.refine)
