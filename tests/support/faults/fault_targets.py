"""Faults of furniture: kinds of objects, sizes, locations, and deletion between two clicks."""

from __future__ import annotations

import math

import bpy
import numpy as np
import rooms
from faults import Case, Room, activate, add, both, lie, meanwhile, nothing, press, seated_on
from mathutils import Matrix
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.pipeline.job import Job

NO_SEAT = "Nobody can sit|no place to sit"


def at_sofa(matrix: Matrix):
    """Transform the sofa about its centre on the floor."""

    def arrange(room: Room) -> None:
        pivot = Matrix.Translation(middle(room))
        room.sofa.matrix_world = pivot @ matrix @ pivot.inverted() @ room.sofa.matrix_world

    return arrange


def middle(room: Room) -> tuple[float, float, float]:
    points = np.array([vertex.co for vertex in room.sofa.data.vertices])
    return *((points.min(0) + points.max(0)) / 2)[:2], 0.0


def broken_vertices(room: Room) -> None:
    room.sofa.data.vertices[3].co.x = float("nan")


def broken_elsewhere(room: Room) -> None:
    bpy.data.objects["Obstacle 2"].data.vertices[3].co.x = float("inf")


def emptied(room: Room) -> None:
    room.sofa.data.clear_geometry()


def wires(room: Room) -> None:
    room.sofa.data.clear_geometry()
    room.sofa.data.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])


def walled(room: Room) -> None:
    """Add walls around the sofa."""
    x, y, _ = middle(room)
    mesh = bpy.data.meshes.new("Walls")
    corners = [(x - 2, y - 2), (x + 2, y - 2), (x + 2, y + 2), (x - 2, y + 2)]
    points = [(*corner, z) for corner in corners for z in (0, 3)]
    mesh.from_pydata(
        points, [], [(2 * k, 2 * ((k + 1) % 4), 2 * ((k + 1) % 4) + 1, 2 * k + 1) for k in range(4)]
    )
    add("", "Walls", mesh)


def buried(room: Room) -> None:
    """Add a closed crate around the sofa."""
    x, y, _ = middle(room)
    bpy.ops.mesh.primitive_cube_add(size=3, location=(x, y, 1.4))


def in_the_air(room: Room) -> None:
    room.sofa.location.z += 6


def far_away(room: Room) -> None:
    room.sofa.location.x += 10_000


def curve(bevel: float):
    def arrange(room: Room) -> None:
        data = bpy.data.curves.new("Rope", "CURVE")
        data.dimensions, data.bevel_depth = "3D", bevel
        spline = data.splines.new("POLY")
        spline.points.add(1)
        spline.points[1].co = 0.3, 0, 0, 1
        add("", "Thing", data, (3, 3, 0.5))

    return arrange


def text(room: Room) -> None:
    data = bpy.data.curves.new("Sign", "FONT")
    data.body, data.extrude = "SOFA", 0.05
    add("", "Thing", data, (3, 3, 0))


def metaball(room: Room) -> None:
    data = bpy.data.metaballs.new("Blob")
    data.elements.new().radius = 1.0
    add("", "Thing", data, (3, 3, 0))
    bpy.context.view_layer.update()


def instanced(room: Room) -> None:
    """Replace the sofa by an instance of a collection that is not in the scene."""
    collection = bpy.data.collections.new("Stock")
    collection.objects.link(room.sofa)
    room.scene.collection.objects.unlink(room.sofa)
    shown = add("", "Thing")
    shown.instance_type, shown.instance_collection = "COLLECTION", collection


def under_an_empty(room: Room) -> None:
    room.sofa.parent = add("", "Thing", at=(0, 0, 0))


def in_a_collection(room: Room) -> None:
    collection = bpy.data.collections.new("Thing")
    room.scene.collection.children.link(collection)
    collection.objects.link(room.sofa)


def instance_of_itself(room: Room) -> None:
    collection = bpy.data.collections.new("Loop")
    room.scene.collection.children.link(collection)
    shown = add("", "Thing")
    collection.objects.link(room.sofa)
    shown.instance_type, shown.instance_collection = "COLLECTION", collection


def one_sided_top(room: Room) -> None:
    """Add a plane of 40 m by 40 m: a floor, not a seat."""
    mesh = bpy.data.meshes.new("Top")
    mesh.from_pydata([(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)], [], [(0, 1, 2, 3)])
    add("", "Thing", mesh, (100, 0, 0))


def small(kind: str):
    return lambda room: add(kind, "Thing")


def modified(room: Room) -> None:
    """Add a Bevel modifier to the sofa."""
    modifier = room.sofa.modifiers.new("Bevel", "BEVEL")
    modifier.width, modifier.segments = 0.01, 2


def nothing_left_by_a_modifier(room: Room) -> None:
    room.sofa.modifiers.new("Mask", "MASK").vertex_group = "None of this name"
    room.sofa.vertex_groups.new(name="Nothing")
    room.sofa.modifiers["Mask"].vertex_group = "Nothing"


def goals(room: Room) -> None:
    bpy.ops.samp.sample_goals(target="Sofa", count=2)


def first_arrow() -> bpy.types.Object:
    return next(thing for thing in bpy.context.scene.objects if thing.name.startswith("Goal"))


def arrow_deleted(room: Room) -> None:
    bpy.data.objects.remove(first_arrow())


def arrow_up(room: Room) -> None:
    for thing in bpy.context.scene.objects:
        if thing.name.startswith("Goal"):
            thing.matrix_world = Matrix.Translation(thing.matrix_world.translation)


def arrow_away(room: Room) -> None:
    for thing in bpy.context.scene.objects:
        if thing.name.startswith("Goal"):
            thing.location.x += 5


def gone(name: str):
    """Return the deletion of an object with its mesh."""
    return lambda room: bpy.data.meshes.remove(bpy.data.objects[name].data)


def clicked(name: str):
    return lambda room: activate(bpy.data.objects[name])


def turned(axis: str, degrees: float) -> Matrix:
    return Matrix.Rotation(math.radians(degrees), 4, axis)


def bed_of_30_m(room: Room) -> None:
    mesh = bpy.data.meshes.new("Bed")
    points = frames.to_blender(rooms.box((-15, 0, -15), (15, 0.5, 15)).reshape(-1, 3))
    mesh.from_pydata(points.tolist(), [], np.arange(36).reshape(-1, 3).tolist())
    add("", "Thing", mesh, (30, 0, 0))


ON_THING = seated_on("Thing")
MIRROR = Matrix.Diagonal((-1, 1, 1, 1))

CASES = (
    Case("no way to the sofa", walled, message="way|reach"),
    Case("sofa inside a closed crate", buried, message="way|reach|" + NO_SEAT),
    Case("sofa in the air", in_the_air, message="begins .* above the floor"),
    Case("sofa 10 km away", far_away, message="It is [0-9]+ m from"),
    Case(
        "sofa upside down",
        at_sofa(Matrix.Translation((0, 0, 0.9)) @ turned("X", 180)),
        press=seated_on("Sofa"),
    ),
    Case("sofa on its side", at_sofa(turned("Y", 90)), message=NO_SEAT + "|way"),
    Case("sofa of 3 cm", at_sofa(Matrix.Scale(0.015, 4)), message=NO_SEAT),
    Case("sofa of 30 m", at_sofa(Matrix.Scale(15, 4)), message=NO_SEAT + "|a unit is a metre"),
    Case("bed of 30 m", bed_of_30_m, press=lambda room: lie(room, target="Thing")),
    Case("sofa scaled to nothing", at_sofa(Matrix.Scale(0, 4)), message="no area"),
    Case("mirrored sofa", at_sofa(MIRROR)),
    Case("sheared sofa", at_sofa(Matrix.Shear("XY", 4, (0.1, 0.1)))),
    Case("vertices that are not finite", broken_vertices, message="'Sofa'"),
    Case("an obstacle with vertices that are not finite", broken_elsewhere, message="'Obstacle 2'"),
    Case("empty mesh", emptied, message="'Sofa' has no faces"),
    Case("edges without faces", wires, message="'Sofa' has no faces"),
    Case("curve with a surface", curve(0.02), message=NO_SEAT, press=ON_THING),
    Case("curve without a surface", curve(0.0), message="'Thing' has no faces", press=ON_THING),
    Case("text", text, message=NO_SEAT, press=ON_THING),
    Case("metaball", metaball, message=NO_SEAT, press=ON_THING),
    Case("instance of a collection", instanced, press=ON_THING),
    Case("instance of a collection that is also in the scene", instance_of_itself, press=ON_THING),
    Case("children of an empty", under_an_empty, press=ON_THING),
    Case("a collection", in_a_collection, press=ON_THING),
    Case("empty without children", small(""), message="'Thing' has no faces", press=ON_THING),
    Case("lattice", small("lattices"), message="'Thing' has no faces", press=ON_THING),
    Case("camera", small("cameras"), message="'Thing' has no faces", press=ON_THING),
    Case("the character itself", nothing, message="'Human'", press=seated_on("Human")),
    Case("the character's own skin", nothing, message="'Human mesh'", press=seated_on("Human mesh")),
    Case("a ground of 40 m", one_sided_top, message=NO_SEAT, press=ON_THING),
    Case("sofa with a modifier", modified),
    Case(
        "sofa with a modifier that leaves nothing", nothing_left_by_a_modifier, message="'Sofa' has no faces"
    ),
    Case("goals that an artist chose", goals),
    Case("a goal's arrow deleted", both(goals, arrow_deleted)),
    Case("goals that point up", both(goals, arrow_up), message="points up or down"),
    Case("goals beside the sofa", both(goals, arrow_away), message="arrow 'Goal"),
    Case(
        "the goals' sofa deleted, its arrow clicked",
        both(goals, lambda room: activate(first_arrow()), gone("Sofa")),
        message="no 'Sofa'",
        press=seated_on(""),
    ),
    Case("sofa deleted before the press", gone("Sofa"), message="no 'Sofa' in the scene"),
    Case(
        "sofa deleted while the thread works",
        nothing,
        press=meanwhile(gone("Sofa"), Job(target="Sofa")),
        changes=(".*Sofa.*", "scenes/.*"),
    ),
    Case(
        "the floor deleted while the thread works",
        nothing,
        press=meanwhile(gone("Floor")),
        changes=(".*Floor.*", "scenes/.*"),
    ),
    Case(
        "voxels of an empty mesh",
        emptied,
        message="'Sofa' has no faces",
        press=press("voxelise", target="Sofa"),
    ),
    Case(
        "a way to a sofa in the air",
        in_the_air,
        message="free floor",
        press=press("plan_path", target="Sofa"),
    ),
    Case(
        "goals on a crate of 3 cm",
        at_sofa(Matrix.Scale(0.015, 4)),
        message=NO_SEAT,
        networks=True,
        press=press("sample_goals", target="Sofa"),
    ),
    Case(
        "a soft seat of a camera",
        both(small("cameras"), clicked("Thing")),
        message="No furniture is selected",
        press=press("set_cushion"),
    ),
)
