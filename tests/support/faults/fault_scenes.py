"""Faults of scenes: units, locations, frame rates, names, hidden and missing objects."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from faults import Case, Room, activate, arrived, both, nothing, press, seated_on, sit, with_take
from mathutils import Matrix
from samp_blender.samp_addon.blender.actions import keyframes

NAMES = {
    "quotes": "A \"big\" 'soft' sofa",
    "dots and numbers": "sofa.v2.001",
    "an emoji": "🛋️ Sofa für Ödön",
    "63 characters": "s" * 63,
    "a backslash and brackets": 'so\\fa["x"]',
    "a space at its end": "sofa ",
}


def units(system: str, length: str, scale: float = 1.0):
    def arrange(room: Room) -> None:
        room.scene.unit_settings.system = system
        if system != "NONE":
            room.scene.unit_settings.length_unit = length
        room.scene.unit_settings.scale_length = scale

    return arrange


def moved(matrix: Matrix):
    """Transform the whole room."""

    def arrange(room: Room) -> None:
        for thing in room.scene.objects:
            if thing.parent is None:
                thing.matrix_world = matrix @ thing.matrix_world

    return arrange


def in_centimetres(alone: bool):
    """Scale the room by 100 and set the unit to a centimetre."""

    def arrange(room: Room) -> None:
        units("METRIC", "METERS", 0.01)(room)
        if alone:
            without("Human")(room)
        moved(Matrix.Scale(100, 4))(room)

    return arrange


def rate(fps: int, base: float = 1.0):
    def arrange(room: Room) -> None:
        room.scene.render.fps, room.scene.render.fps_base = fps, base

    return arrange


def lasts_as_long(room: Room) -> None:
    """Assert that the take has the scene's frame rate and lasts as long as at 30 frames per second."""
    rate_ = keyframes.frames_per_second(room.scene)
    first, last = room.owner.animation_data.action.frame_range
    notes = room.owner.animation_data.action["samp"]
    assert (notes["frame_start"], notes["frame_end"]) == (first, last)
    seconds = (last - first) / rate_
    rate(30)(room)
    sit(room, seed=0)  # the first press's; the sidebar's has gone on
    first, last = room.owner.animation_data.action.frame_range
    assert seconds == pytest.approx((last - first) / 30, abs=1.5 / 24)


def baked_at_minus_50(room: Room) -> object:
    """Bake at a frame before the earliest start of a scene, which keyframes allow."""
    with_take(room)
    bpy.ops.samp.export_npz(filepath=str(room.files / "take.npz"))
    return bpy.ops.samp.bake("EXEC_DEFAULT", True, filepath=str(room.files / "take.npz"), frame_start=-50)


def begins_at_minus_50(room: Room) -> None:
    assert tuple(room.owner.animation_data.action.frame_range) == (-50, -11)
    assert bpy.ops.samp.refine() == {"FINISHED"}
    assert tuple(room.owner.animation_data.action.frame_range) == (-50, -11)


def first_frame(room: Room) -> None:
    room.scene.frame_start, room.scene.frame_end = 1001, 1100


def begins_at_1001(room: Room) -> None:
    assert room.owner.animation_data.action.frame_range[0] == 1001


def renamed(name: str):
    def arrange(room: Room) -> None:
        room.sofa.name = name

    return arrange


def named_after(name: str):
    def check(room: Room) -> None:
        assert room.owner.animation_data.action.name.startswith("sit ")
        assert name[:40] in room.owner.animation_data.action.name

    return check


def second_scene(room: Room) -> None:
    other = bpy.data.scenes.new("Other")
    mesh = bpy.data.meshes.new("Crate")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 1)], [], [(0, 1, 2)])
    other.collection.objects.link(bpy.data.objects.new("Crate", mesh))


def in_second_scene(room: Room) -> None:
    second_scene(room)
    bpy.context.window.scene = bpy.data.scenes["Other"]


def crowd(room: Room) -> None:
    """Add 5,000 small objects and empties in a corner of the room."""
    mesh = bpy.data.meshes.new("Pebble")
    mesh.from_pydata([(0, 0, 0), (0.02, 0, 0), (0, 0.02, 0.02)], [], [(0, 1, 2)])
    at = np.random.default_rng(0).uniform(3.0, 3.9, (5000, 2))
    for number, (x, y) in enumerate(at):
        thing = bpy.data.objects.new("Pebble", mesh if number % 2 else None)
        thing.location = x, y, 0.0
        room.scene.collection.objects.link(thing)


def excluded(name: str):
    def arrange(room: Room) -> None:
        collection = bpy.data.collections.new("Stored")
        room.scene.collection.children.link(collection)
        thing = bpy.data.objects[name]
        collection.objects.link(thing)
        room.scene.collection.objects.unlink(thing)
        bpy.context.view_layer.layer_collection.children["Stored"].exclude = True

    return arrange


def without(*names: str):
    def arrange(room: Room) -> None:
        for name in names:
            bpy.data.objects.remove(bpy.data.objects[name])

    return arrange


def empty(room: Room) -> None:
    for thing in list(room.scene.objects):
        bpy.data.objects.remove(thing)


def hidden(name: str, **flags: bool):
    def arrange(room: Room) -> None:
        thing = bpy.data.objects[name]
        for flag, value in flags.items():
            setattr(thing, flag, value)
        if not flags:
            thing.hide_set(True)

    return arrange


def laid_ground(room: Room) -> None:
    assert room.owner.animation_data.action["samp_ground"] == pytest.approx(0, abs=0.05)


def own_ground(room: Room) -> None:
    assert "samp_ground" not in room.owner.animation_data.action


def second_layer(room: Room) -> None:
    room.scene.view_layers.new("Props")
    bpy.context.window.view_layer = room.scene.view_layers["Props"]


def active_collection_hidden(room: Room) -> None:
    collection = bpy.data.collections.new("Away")
    room.scene.collection.children.link(collection)
    bpy.context.view_layer.active_layer_collection = bpy.context.view_layer.layer_collection.children["Away"]
    collection.hide_viewport = True


def made_and_seated(room: Room) -> None:
    assert bpy.context.view_layer.objects.active.type == "ARMATURE"


NEW_HUMAN = (r".*(\.active|\.shown/.*)$", r"scenes/.*")

CASES = (
    Case("nothing is odd", nothing),
    Case("the real networks", nothing, networks=True),
    *(
        Case(f"lengths in {unit.lower()}", units(kind, unit))
        for kind, unit in (("METRIC", "CENTIMETERS"), ("IMPERIAL", "FEET"), ("NONE", "METERS"))
    ),
    Case("floor at 37 m", moved(Matrix.Translation((0, 0, 37)))),
    Case("floor at -37 m with the real networks", moved(Matrix.Translation((0, 0, -37))), networks=True),
    Case("a kilometre away", moved(Matrix.Translation((1000, -1000, 0)))),
    Case("turned by 33 degrees", moved(Matrix.Rotation(math.radians(33), 4, "Z"))),
    *(
        Case(f"{fps / base:.2f} frames a second", rate(fps, base), check=lasts_as_long)
        for fps, base in ((24, 1.0), (25, 1.0), (60, 1.001), (240, 1.0))
    ),
    Case("one frame a second", rate(1)),
    Case("first frame 1001", first_frame, check=begins_at_1001),
    Case("baked at frame -50", nothing, press=baked_at_minus_50, check=begins_at_minus_50),
    Case("a unit scale that does not match the models", units("METRIC", "METERS", 0.01)),
    Case("in centimetres by unit scale", in_centimetres(False), message="Human.*Unit Scale of 0.01"),
    Case(
        "in centimetres by unit scale, without a character",
        in_centimetres(True),
        message="Unit Scale of 0.01",
    ),
    Case("in feet by unit scale", units("IMPERIAL", "FEET", 0.3048)),
    *(
        Case(f"a sofa with {what} in its name", renamed(name), press=seated_on(name), check=named_after(name))
        for what, name in NAMES.items()
    ),
    Case("two scenes", second_scene),
    Case("in the other scene", in_second_scene, message="no 'Sofa' in the scene"),
    Case("5,000 objects", crowd),
    Case("sofa in an excluded collection", excluded("Sofa"), message="'Sofa' is hidden"),
    Case("character in an excluded collection", excluded("Human")),
    Case("floor in an excluded collection", excluded("Floor"), check=laid_ground),
    Case("an empty scene", empty, message="no 'Sofa' in the scene"),
    Case("navmesh of an empty scene", empty, message="has no faces", press=press("build_navmesh")),
    Case("path in an empty scene", empty, message="has no faces", press=press("plan_path", to_cursor=True)),
    Case("no floor", without("Floor"), check=laid_ground),
    Case(
        "only a floor",
        without("Sofa", *(f"Obstacle {k}" for k in range(1, 6))),
        press=press("walk_here", location=(3, 3, 0)),
        check=lambda room: arrived(),
    ),
    Case("hidden sofa", hidden("Sofa"), message="'Sofa' is hidden"),
    Case("sofa off in viewports", hidden("Sofa", hide_viewport=True), message="'Sofa' is hidden"),
    Case("sofa off in renders", hidden("Sofa", hide_render=True), message="'Sofa' is hidden"),
    Case("sofa that cannot be selected", hidden("Sofa", hide_select=True)),
    # What the viewport hides is rendered and counts, unless its collection is excluded.
    Case("hidden floor", hidden("Floor"), check=own_ground),
    Case("a second view layer", second_layer),
    Case("nothing is active", lambda room: activate(None)),
    Case(
        "nothing is active, and nothing named",
        lambda room: activate(None),
        message="No furniture is selected",
        press=seated_on(""),
    ),
    Case(
        "nothing is active for goals",
        lambda room: activate(None),
        message="No furniture is selected",
        press=press("sample_goals"),
    ),
    Case(
        "nothing is active for a soft seat",
        lambda room: activate(None),
        message="No furniture is selected",
        press=press("set_cushion"),
    ),
    Case(
        "a new human in a hidden collection",
        both(without("Human"), active_collection_hidden),
        check=made_and_seated,
        owner=None,
        changes=NEW_HUMAN,
    ),
    Case(
        "a new human where there is none",
        without("Human"),
        check=made_and_seated,
        owner=None,
        changes=NEW_HUMAN,
    ),
)
