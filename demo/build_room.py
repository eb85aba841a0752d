"""Build a furnished living room: python demo/build_room.py OUT.blend

Metres, Z up. Pieces are built facing -Y and then placed; the parts of each are parented to an empty, as in artists'
files.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import bmesh
import bpy
import numpy as np
from samp_blender.samp_addon.blender import compat

COLOURS = {
    "wall": (0.86, 0.83, 0.77),
    "trim": (0.94, 0.93, 0.90),
    "floor": (0.58, 0.41, 0.27),
    "sky": (0.62, 0.80, 0.94),
    "rug": (0.70, 0.36, 0.28),
    "rug edge": (0.91, 0.84, 0.72),
    "sofa": (0.20, 0.38, 0.45),
    "sofa cushion": (0.25, 0.46, 0.53),
    "pillow": (0.93, 0.68, 0.25),
    "armchair": (0.76, 0.55, 0.30),
    "armchair cushion": (0.84, 0.64, 0.38),
    "wood": (0.46, 0.28, 0.15),
    "light wood": (0.74, 0.55, 0.34),
    "metal": (0.25, 0.25, 0.27),
    "pot": (0.75, 0.39, 0.26),
    "leaf": (0.22, 0.47, 0.22),
    "lamp": (0.97, 0.90, 0.70),
}
BOOKS = ((0.62, 0.20, 0.18), (0.18, 0.34, 0.52), (0.84, 0.68, 0.30), (0.30, 0.45, 0.32), (0.45, 0.30, 0.48))
WIDTH, DEPTH, HEIGHT = 7.0, 6.0, 2.6
WALL = 0.12


class Room:
    """A scene being furnished."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        self.scene = scene
        self._parent: bpy.types.Object | None = None
        self._materials: dict[tuple, bpy.types.Material] = {}

    @contextmanager
    def piece(self, name: str, at: tuple[float, float], turn: float = 0.0) -> Iterator[None]:
        """Parent the parts added inside the context to an empty at (x, y), rotated counter-clockwise by degrees."""
        self._parent = bpy.data.objects.new(name, None)
        self._parent.empty_display_size = 0.2
        self.scene.collection.objects.link(self._parent)
        yield
        self._parent.location = (*at, 0.0)
        self._parent.rotation_euler = (0.0, 0.0, math.radians(turn))
        self._parent = None

    def box(
        self,
        name: str,
        size: tuple[float, float, float],
        at: tuple[float, float, float],
        colour: str | tuple[float, float, float],
        soft: float = 0.0,
        tilt: float = 0.0,
    ) -> bpy.types.Object:
        """Add a box whose bottom is centred at ``at``. soft: radius of its edges, metres. tilt: degrees about X."""
        shape = bmesh.new()
        bmesh.ops.create_cube(shape, size=1.0)
        bmesh.ops.scale(shape, verts=shape.verts, vec=size)
        bmesh.ops.translate(shape, verts=shape.verts, vec=(0.0, 0.0, size[2] / 2))
        obj = self._add(name, shape, at, colour)
        obj.rotation_euler[0] = math.radians(tilt)
        if soft:
            bevel = obj.modifiers.new("Soft edges", "BEVEL")
            bevel.width, bevel.segments = soft, 4
            self._smooth(obj)
        return obj

    def pole(
        self,
        name: str,
        radius: tuple[float, float],
        height: float,
        at: tuple[float, float, float],
        colour: str,
        sides: int = 20,
    ) -> bpy.types.Object:
        """Add a cone or cylinder. radius: at the bottom and at the top, metres."""
        shape = bmesh.new()
        bmesh.ops.create_cone(
            shape, cap_ends=True, segments=sides, radius1=radius[0], radius2=radius[1], depth=height
        )
        bmesh.ops.translate(shape, verts=shape.verts, vec=(0.0, 0.0, height / 2))
        return self._add(name, shape, at, colour)

    def legs(self, width: float, depth: float, height: float, colour: str, thick: float = 0.025) -> None:
        """Add four tapered legs at the corners of a rectangle."""
        for x in (-width / 2, width / 2):
            for y in (-depth / 2, depth / 2):
                self.pole("Leg", (thick * 0.7, thick), height, (x, y, 0.0), colour, 12)

    def material(self, colour: str | tuple[float, float, float]) -> bpy.types.Material:
        """Return the material of a colour, created at its first use."""
        value = COLOURS[colour] if isinstance(colour, str) else colour
        if value not in self._materials:
            obj = compat.new_node_material(colour if isinstance(colour, str) else "book")
            linear = [((c + 0.055) / 1.055) ** 2.4 for c in value]
            obj.diffuse_color = (*linear, 1.0)
            shader = obj.node_tree.nodes["Principled BSDF"]
            shader.inputs["Base Color"].default_value = (*linear, 1.0)
            shader.inputs["Roughness"].default_value = 0.7
            self._materials[value] = obj
        return self._materials[value]

    def _add(self, name: str, shape: bmesh.types.BMesh, at: tuple, colour: str | tuple) -> bpy.types.Object:
        mesh = bpy.data.meshes.new(name)
        shape.to_mesh(mesh)
        shape.free()
        mesh.materials.append(self.material(colour))
        obj = bpy.data.objects.new(name if self._parent is None else f"{self._parent.name} {name}", mesh)
        obj.location, obj.parent = at, self._parent
        self.scene.collection.objects.link(obj)
        return obj

    @staticmethod
    def _smooth(obj: bpy.types.Object) -> None:
        obj.data.polygons.foreach_set("use_smooth", np.ones(len(obj.data.polygons), bool))


def walls(room: Room) -> None:
    """Add a floor, the back wall with a window, and the left wall; two sides are open to the camera."""
    room.box("Floor", (WIDTH, DEPTH, 0.1), (0.0, 0.0, -0.1), "floor")
    for k in range(int(WIDTH / 0.35)):
        room.box("Board gap", (0.012, DEPTH, 0.001), (-WIDTH / 2 + 0.35 * (k + 1), 0.0, 0.0), "wood")
    back, left = DEPTH / 2 + WALL / 2, -WIDTH / 2 - WALL / 2
    window = (1.9, 1.15, 1.0)  # width, height, sill
    x, side = 0.3, (WIDTH - window[0]) / 2
    room.box("Wall left", (WALL, DEPTH + 2 * WALL, HEIGHT), (left, 0.0, 0.0), "wall")
    room.box("Wall back left", (side + x, WALL, HEIGHT), (-WIDTH / 2 + (side + x) / 2, back, 0.0), "wall")
    room.box("Wall back right", (side - x, WALL, HEIGHT), (WIDTH / 2 - (side - x) / 2, back, 0.0), "wall")
    room.box("Wall under window", (window[0], WALL, window[2]), (x, back, 0.0), "wall")
    top = window[2] + window[1]
    room.box("Wall over window", (window[0], WALL, HEIGHT - top), (x, back, top), "wall")
    room.box("Sky", (window[0], 0.01, window[1]), (x, back + 0.05, window[2]), "sky")
    for z in (window[2] - 0.03, top - 0.03):
        room.box("Window frame", (window[0] + 0.12, WALL + 0.06, 0.06), (x, back, z), "trim", 0.01)
    for at in (-window[0] / 2, 0.0, window[0] / 2):
        room.box("Window post", (0.06, WALL + 0.04, window[1]), (x + at, back, window[2]), "trim", 0.01)
    room.box("Skirting back", (WIDTH, 0.02, 0.09), (0.0, DEPTH / 2 - 0.01, 0.0), "trim")
    room.box("Skirting left", (0.02, DEPTH, 0.09), (-WIDTH / 2 + 0.01, 0.0, 0.0), "trim")


def sofa(room: Room) -> None:
    """Add a sofa for three, 2.2 m wide, with a seat height of 44 cm."""
    room.legs(2.0, 0.7, 0.12, "wood", 0.03)
    room.box("Base", (2.2, 0.86, 0.18), (0.0, 0.0, 0.12), "sofa", 0.03)
    room.box("Back", (2.2, 0.20, 0.55), (0.0, 0.36, 0.28), "sofa", 0.06, tilt=-6)
    for x in (-1.02, 1.02):
        room.box("Arm", (0.18, 0.88, 0.46), (x, 0.0, 0.14), "sofa", 0.06)
    for x in (-0.61, 0.0, 0.61):
        room.box("Seat cushion", (0.60, 0.68, 0.15), (x, -0.08, 0.29), "sofa cushion", 0.045)
        room.box("Back cushion", (0.59, 0.14, 0.40), (x, 0.24, 0.43), "sofa cushion", 0.05, tilt=-9)
    room.box("Pillow", (0.38, 0.12, 0.36), (-0.72, 0.09, 0.46), "pillow", 0.055, tilt=-14)


def armchair(room: Room) -> None:
    """Add a low, deep armchair."""
    room.legs(0.62, 0.62, 0.14, "wood", 0.028)
    room.box("Base", (0.80, 0.78, 0.16), (0.0, 0.0, 0.14), "armchair", 0.03)
    room.box("Back", (0.80, 0.17, 0.62), (0.0, 0.33, 0.26), "armchair", 0.06, tilt=-8)
    for x in (-0.34, 0.34):
        room.box("Arm", (0.13, 0.74, 0.44), (x, -0.01, 0.16), "armchair", 0.045)
    room.box("Seat cushion", (0.54, 0.62, 0.14), (0.0, -0.07, 0.29), "armchair cushion", 0.045)


def chair(room: Room) -> None:
    """Add a dining chair with slats."""
    room.legs(0.36, 0.36, 0.43, "light wood", 0.022)
    room.box("Seat", (0.43, 0.42, 0.035), (0.0, 0.0, 0.425), "light wood", 0.012)
    for x in (-0.18, 0.18):
        room.box("Post", (0.035, 0.03, 0.48), (x, 0.19, 0.44), "light wood", 0.008, tilt=-7)
    for z in (0.60, 0.72, 0.84):
        room.box("Slat", (0.36, 0.02, 0.07), (0.0, 0.19 + (z - 0.44) * 0.12, z), "light wood", 0.006, tilt=-7)


def coffee_table(room: Room) -> None:
    """Add a coffee table with a shelf, a bowl and two books."""
    room.legs(0.98, 0.46, 0.38, "wood", 0.024)
    room.box("Top", (1.1, 0.56, 0.035), (0.0, 0.0, 0.375), "wood", 0.01)
    room.box("Shelf", (0.94, 0.42, 0.02), (0.0, 0.0, 0.16), "wood", 0.005)
    room.pole("Bowl", (0.06, 0.12), 0.07, (0.25, 0.05, 0.41), "pot")
    room.box("Book", (0.24, 0.17, 0.03), (-0.25, -0.04, 0.41), BOOKS[1])
    room.box("Book", (0.21, 0.15, 0.025), (-0.24, -0.03, 0.44), BOOKS[2])


def dining_table(room: Room) -> None:
    """Add a dining table for four."""
    room.legs(1.2, 0.68, 0.71, "light wood", 0.035)
    room.box("Top", (1.35, 0.82, 0.04), (0.0, 0.0, 0.71), "light wood", 0.012)
    room.pole("Vase", (0.05, 0.035), 0.22, (0.1, 0.0, 0.75), "sky")


def bookshelf(room: Room) -> None:
    """Add a bookshelf with four rows of books."""
    width, depth, height = 1.3, 0.32, 1.9
    for x in (-width / 2, width / 2):
        room.box("Side", (0.03, depth, height), (x, 0.0, 0.0), "wood")
    room.box("Back", (width, 0.015, height), (0.0, depth / 2, 0.0), "wood")
    rng = np.random.default_rng(4)
    for k in range(5):
        shelf = 0.04 + k * 0.46
        room.box("Shelf", (width, depth, 0.03), (0.0, 0.0, shelf), "wood")
        x = -width / 2 + 0.06
        while k < 4 and x < width / 2 - 0.3 * rng.random() - 0.08:
            thick, tall = rng.uniform(0.03, 0.06), rng.uniform(0.22, 0.34)
            colour = BOOKS[int(rng.integers(len(BOOKS)))]
            room.box("Book", (thick, 0.2, tall), (x + thick / 2, 0.02, shelf + 0.03), colour)
            x += thick + 0.004


def sideboard(room: Room) -> None:
    """Add a sideboard with two doors."""
    room.legs(1.4, 0.3, 0.16, "metal", 0.018)
    room.box("Body", (1.6, 0.42, 0.44), (0.0, 0.0, 0.16), "wood", 0.01)
    for x in (-0.4, 0.4):
        room.box("Door", (0.76, 0.02, 0.38), (x, -0.215, 0.19), "light wood", 0.006)


def plant(room: Room) -> None:
    """Add a potted plant with long leaves."""
    room.pole("Pot", (0.15, 0.19), 0.34, (0.0, 0.0, 0.0), "pot")
    rng = np.random.default_rng(2)
    for k in range(16):
        length = float(rng.uniform(0.5, 0.85))
        leaf = room.pole("Leaf", (0.05, 0.004), length, (0.0, 0.0, 0.32), "leaf", 6)
        leaf.scale[1] = 0.2
        leaf.rotation_euler = (float(rng.uniform(0.1, 0.65)), 0.0, k * 2.4)
        leaf.rotation_mode = "ZYX"


def floor_lamp(room: Room) -> None:
    """Add a floor lamp."""
    room.pole("Foot", (0.14, 0.14), 0.02, (0.0, 0.0, 0.0), "metal")
    room.pole("Pole", (0.012, 0.012), 1.45, (0.0, 0.0, 0.02), "metal", 10)
    room.pole("Shade", (0.20, 0.14), 0.28, (0.0, 0.0, 1.42), "lamp")


def rug(room: Room) -> None:
    """Add a rug, flat enough to walk over."""
    room.box("Border", (2.9, 2.0, 0.008), (0.0, 0.0, 0.0), "rug edge")
    room.box("Middle", (2.7, 1.8, 0.010), (0.0, 0.0, 0.0), "rug")


def light(scene: bpy.types.Scene) -> None:
    """Add a sun, a soft light and a camera that sees the room."""
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.5, (math.radians(50), 0.0, math.radians(25))
    area = bpy.data.objects.new("Ceiling light", bpy.data.lights.new("Ceiling light", "AREA"))
    area.data.energy, area.data.size, area.location = 120.0, 3.0, (0.0, -0.5, 2.9)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 28
    camera.location = (5.4, -6.4, 3.3)
    camera.rotation_euler = (math.radians(68), 0.0, math.radians(38))
    for obj in (sun, area, camera):
        scene.collection.objects.link(obj)
    scene.camera = camera
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.color = (0.75, 0.82, 0.90)


def build(scene: bpy.types.Scene) -> None:
    """Furnish an empty scene."""
    room = Room(scene)
    walls(room)
    pieces = (
        ("Rug", rug, (0.3, 0.95), 0),
        ("Sofa", sofa, (0.3, 2.42), 0),
        ("Coffee table", coffee_table, (0.3, 1.05), 0),
        ("Armchair", armchair, (-1.75, 1.25), 62),
        ("Bookshelf", bookshelf, (-3.3, 0.4), 90),
        ("Sideboard", sideboard, (3.25, 0.6), -90),
        ("Dining table", dining_table, (-1.75, -1.45), 0),
        ("Chair 1", chair, (-2.1, -2.12), 180),
        ("Chair 2", chair, (-1.4, -2.12), 174),
        ("Chair 3", chair, (-2.1, -0.78), 0),
        ("Chair 4", chair, (-1.4, -0.74), -8),
        ("Plant", plant, (2.95, 2.45), 0),
        ("Floor lamp", floor_lamp, (-1.35, 2.55), 0),
    )
    for name, make, at, turn in pieces:
        with room.piece(name, at, turn):
            make(room)
    light(scene)
    scene.render.fps = 30
    bpy.context.view_layer.update()


def main(path: str) -> None:
    """Write the room to a .blend file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    build(bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=path)


if __name__ == "__main__":
    main(sys.argv[-1])
