"""Faults of timing: every mode, and changes by the artist while a thread works."""

from __future__ import annotations

import bpy
from fault_characters import another_rig
from faults import Case, Room, activate, both, meanwhile, nothing

SELECTION = (r".*(\.active|\.shown/.*)$", r"context\.mode", r"objects/.*\.mode$")
GO_TO = "Go to Object or Pose Mode first"


def in_mode(mode: str, name: str):
    def arrange(room: Room) -> None:
        activate(bpy.data.objects[name])
        bpy.ops.object.mode_set(mode=mode)

    return arrange


def gone(room: Room) -> None:
    bpy.data.objects.remove(room.owner)


def edited(room: Room) -> None:
    activate(room.sofa)
    bpy.ops.object.mode_set(mode="EDIT")


def saved(room: Room) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(room.files / "meanwhile.blend"), copy=True)


def renamed_meanwhile(room: Room) -> None:
    room.owner.name = "Eva"


def opened(room: Room) -> None:
    """Reload the file: all Python references become invalid."""
    bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath, load_ui=False)


CASES = (
    Case("pose mode", in_mode("POSE", "Human")),
    *(
        Case(f"{mode.lower()} mode of {name}", in_mode(mode, name), message=GO_TO)
        for mode, name in (
            ("EDIT", "Human"),
            ("EDIT", "Sofa"),
            ("SCULPT", "Sofa"),
            ("WEIGHT_PAINT", "Human mesh"),
            ("VERTEX_PAINT", "Sofa"),
            ("TEXTURE_PAINT", "Sofa"),
        )
    ),
    Case(
        "a new human in the pose mode of another rig",
        both(gone, another_rig, in_mode("POSE", "Rig")),
        owner=None,
        changes=(*SELECTION, "scenes/.*"),
    ),
    Case(
        "character deleted while the thread works",
        nothing,
        message="gone|deleted",
        press=meanwhile(gone),
        changes=(r".*Human.*", r"scenes/.*", r".*\.active", "armatures/.*"),
    ),
    Case(
        "character renamed while the thread works",
        nothing,
        press=meanwhile(renamed_meanwhile),
        changes=(r".*Human.*", r"scenes/.*", r".*\.active"),
    ),
    Case(
        "another file opened while the thread works", nothing, message="gone|deleted", press=meanwhile(opened)
    ),
    Case("the file saved while the thread works", nothing, press=meanwhile(saved), changes=(r"scenes/.*",)),
    Case(
        "edit mode begun while the thread works",
        nothing,
        press=meanwhile(edited),
        changes=(*SELECTION, "meshes/Sofa.*"),
    ),
    Case(
        "the scene switched while the thread works",
        lambda room: bpy.data.scenes.new("Other"),
        message="gone|deleted",
        press=meanwhile(lambda room: setattr(bpy.context.window, "scene", bpy.data.scenes["Other"])),
        changes=("context.*",),
    ),
    Case(
        "edit mode begun, and a new human to make",
        gone,
        message="go to Object Mode",
        press=meanwhile(edited),
        changes=(*SELECTION, "meshes/Sofa.*"),
    ),
)
