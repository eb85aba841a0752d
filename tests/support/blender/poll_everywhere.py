"""Installs a zip in this process' Blender and runs every operator everywhere; prints one line of JSON for test_polls.

Usage: poll_everywhere.py ZIP FOLDER. The networks are replaced by fakes.
"""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Callable
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.samp"
FOLDER = Path(sys.argv[2])
# Options of operators whose defaults name nothing.
OPTIONS = {
    "sit_here": {"target": "Sofa"},
    "lie_here": {"target": "Bed"},
    "walk_here": {"location": (2.0, 2.0, 0.0)},
    "voxelise": {"target": "Sofa"},
    "sample_goals": {"target": "Sofa"},
    "plan_path": {"target": "Sofa"},
    "bake": {"filepath": str(FOLDER / "take.npz")},
    "export_npz": {"filepath": str(FOLDER / "out.npz")},
}
MODES = {
    "MESH": ("EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"),
    "ARMATURE": ("EDIT", "POSE"),
    "GREASEPENCIL": ("EDIT", "PAINT_GREASE_PENCIL", "SCULPT_GREASE_PENCIL", "WEIGHT_GREASE_PENCIL"),
    "GPENCIL": ("EDIT_GPENCIL", "PAINT_GPENCIL", "SCULPT_GPENCIL", "WEIGHT_GPENCIL"),
    "CURVES": ("EDIT", "SCULPT_CURVES"),
    **dict.fromkeys(("CURVE", "FONT", "LATTICE", "META", "SURFACE"), ("EDIT",)),
}
DATA = {
    "Camera": "cameras",
    "Light": "lights",
    "Lattice": "lattices",
    "Meta": "metaballs",
    "Volume": "volumes",
    "Speaker": "speakers",
    "Rig": "armatures",
    "Pencil": "grease_pencils",
    "Hair": "hair_curves",
}


def mesh(name: str, boxes: list, rooms: object) -> None:
    data = bpy.data.meshes.new(name)
    points, faces = [], []
    for low, high in boxes:
        for triangle in rooms.box(low, high):
            faces.append(range(len(points), len(points) + 3))
            points += [(x, -z, y) for x, y, z in triangle]
    data.from_pydata(points, [], [tuple(face) for face in faces])
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, data))


def furnish(rooms: object) -> None:
    """Add a sofa, a bed, a floor, a human, and an object of every other kind."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    mesh("Floor", [((-4, -0.1, -4), (4, 0, 4))], rooms)
    mesh("Sofa", [((-1, 0, -2), (1, 0.43, -1.2)), ((-1, 0.43, -2), (1, 0.8, -1.8))], rooms)
    mesh("Bed", [((-3.5, 0, 0), (-2.2, 0.5, 2.1))], rooms)
    bpy.ops.samp.create_character("EXEC_DEFAULT", location=(1.5, -1.5, 0))
    made = {
        "Empty": None,
        "Curve": bpy.data.curves.new("Curve", "CURVE"),
        "Text": bpy.data.curves.new("T", "FONT"),
    }
    made["Surface"] = bpy.data.curves.new("Surface", "SURFACE")
    for name, kind in DATA.items():
        # In 4.3 to 4.5 the plain name is that of annotations, which have no objects.
        data = getattr(bpy.data, f"{kind}_v3", getattr(bpy.data, kind, None))
        if data is not None:
            made[name] = data.new(name, "POINT") if kind == "lights" else data.new(name)
    for name, data in made.items():
        thing = bpy.data.objects.new(name, data)
        thing.location = 6.0, 6.0, 0.0  # nearby: the size of the navmesh grows with the distance
        bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.update()


def names() -> list[str]:
    return sorted(dir(bpy.ops.samp))


def activate(name: str | None) -> None:
    for thing in bpy.context.selected_objects:
        thing.select_set(False)
    thing = bpy.data.objects.get(name) if name else None
    bpy.context.view_layer.objects.active = thing
    if thing is not None:
        thing.select_set(True)


def polled() -> dict:
    """Return the poll of every operator, and errors of polls."""
    polls, wrong = {}, {}
    for name in names():
        try:
            polls[name] = getattr(bpy.ops.samp, name).poll()
        except Exception as error:  # any error is a finding
            wrong[name] = repr(error)
    wrong |= {name: repr(answer) for name, answer in polls.items() if not isinstance(answer, bool)}
    return {"mode": bpy.context.mode, "polls": polls, "wrong": wrong}


def pressed() -> dict[str, str]:
    """Run every operator whose poll allows it, with defaults; return its error message, or an empty string."""
    messages = {}
    for name in names():
        operator = getattr(bpy.ops.samp, name)
        if operator.poll():
            try:
                messages[name] = "" if operator("EXEC_DEFAULT", True) else "?"
            except RuntimeError as error:
                messages[name] = str(error)
    return messages


def everywhere() -> dict:
    """Return the polls with each kind of object active, in each of its modes."""
    places = {}
    for name in (None, *sorted(bpy.data.objects.keys())):
        activate(name)
        places[f"{name} in OBJECT"] = polled()
        for mode in MODES.get(bpy.data.objects[name].type if name else "", ()):
            try:
                bpy.ops.object.mode_set(mode=mode)
            except (TypeError, RuntimeError):
                continue  # this Blender has no such mode, or not without a window
            places[f"{name} in {mode}"] = polled()
            bpy.ops.object.mode_set(mode="OBJECT")
    return places


def undone(again: Callable[[], None], fingerprint: object) -> dict[str, list[str]]:
    """Return for each operator that finishes what an undo does not restore."""
    changes = {}
    for name in names():
        again()
        operator = getattr(bpy.ops.samp, name)
        if not (operator.poll() and undoes(name)):
            continue
        bpy.ops.ed.undo_push(message="before")
        before = fingerprint.taken()
        try:
            done = operator("EXEC_DEFAULT", True, **OPTIONS.get(name, {}))
        except RuntimeError:
            continue
        if done == {"FINISHED"}:
            bpy.ops.ed.undo()
            changes[name] = fingerprint.differences(before, fingerprint.taken(), additions=False)
    return changes


def undoes(name: str) -> bool:
    """Return whether an operator pushes an undo step."""
    cls = importlib.import_module(f"{MODULE}.operators").operator_class(name)
    return "UNDO" in cls.bl_options


def main() -> dict:
    bpy.ops.extensions.package_install_files(
        filepath=sys.argv[1], repo="user_default", enable_on_install=True
    )
    sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]
    fakes, rooms, fingerprint = (importlib.import_module(name) for name in ("fakes", "rooms", "fingerprint"))
    part = lambda name: importlib.import_module(f"{MODULE}.samp_addon.{name}")
    part("methods.samp.networks").trained = lambda: fakes.NETWORKS
    part("methods.samp.goals").sample_goals = fakes.sample_goals
    part("refine.refinement").refine = fakes.refine
    bpy.context.preferences.edit.use_global_undo = True
    furnish(rooms)
    facts = {"operators": names(), "places": everywhere(), "pressed": {}}

    def again() -> None:
        furnish(rooms)
        activate("Human")
        bpy.ops.samp.sit_here("EXEC_DEFAULT", True, target="Sofa")
        bpy.ops.samp.export_npz("EXEC_DEFAULT", True, filepath=str(FOLDER / "take.npz"))

    for name, mode in (
        ("Human", "OBJECT"),
        ("Human", "POSE"),
        ("Sofa", "OBJECT"),
        ("Rig", "POSE"),
        (None, "OBJECT"),
    ):
        furnish(rooms)
        activate(name)
        if mode != "OBJECT":
            bpy.ops.object.mode_set(mode=mode)
        facts["pressed"][f"{name} in {mode}"] = pressed()
    facts["undone"] = undone(again, fingerprint)
    # Older Blenders crash at exit when a registered callback is still alive.
    bpy.ops.preferences.addon_disable(module=MODULE)
    return facts


if __name__ == "__main__":
    print("FACTS" + json.dumps(main()))
