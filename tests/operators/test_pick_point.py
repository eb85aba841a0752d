"""A click in a room that is one mesh says which piece is meant."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Vector
from samp_blender.operators.pick_point import PickPoint
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.scene import pieces, read_scene, read_view, targets
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.scene.geometry import extent
from screen import Screen

BOXES = {
    "floor": ((-3, -3, -0.1), (3, 3, 0)),
    "bench": ((-2.5, -0.5, 0), (-1.5, 0.0, 0.42)),
    "stool": ((1.0, 1.0, 0), (1.45, 1.45, 0.5)),
}
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


@pytest.fixture(autouse=True)
def room():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    points, faces = [], []
    for low, high in BOXES.values():
        faces += [tuple(len(points) + k for k in face) for face in FACES]
        points += [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    mesh = bpy.data.meshes.new("Room")
    mesh.from_pydata(points, [], faces)
    made = bpy.data.objects.new("Room", mesh)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.update()
    return made


@pytest.mark.parametrize("name", ["bench", "stool"])
@pytest.mark.parametrize("turn", [0.0, 0.8])
def test_the_point_selects_the_piece(room, name, turn):
    room.rotation_euler.z = turn
    bpy.context.view_layer.update()
    low, high = np.array(BOXES[name])
    top = room.matrix_world @ Vector(((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]))
    scene = read_scene.read_scene(bpy.context)
    step = Step(action="sit", target="Room", point=tuple(top))
    view = read_view.read_view(bpy.context, step, scene, None, (), True)
    size = np.ptp([np.array(room.matrix_world.inverted() @ Vector(p)) for p in corners(view.target)], axis=0)
    assert size == pytest.approx(high - low, abs=1e-4)


def corners(triangles):
    return frames.to_blender(triangles.reshape(-1, 3))


def test_a_small_target_stays_whole(room):
    bpy.ops.mesh.primitive_cube_add(size=1)
    bpy.context.object.name = "Crate"
    scene = read_scene.read_scene(bpy.context)
    target = read_scene.read_target(bpy.context, "Crate")
    _, same = pieces.piece(bpy.context, scene, target, "sit", np.array([5.0, 0.0, 0.0]))
    assert np.array_equal(extent(same.triangles), extent(target.triangles))


def test_a_ray_meets_the_target_behind_other_things(room):
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=(1.2, 1.2, 1.5))
    found = targets.hit(bpy.context, Vector((1.2, 1.2, 5)), Vector((0, 0, -1)), "Room")
    assert found == pytest.approx((1.2, 1.2, 0.5), abs=1e-5)
    assert targets.hit(bpy.context, Vector((9, 9, 5)), Vector((0, 0, -1)), "Room") is None
    assert targets.is_room(bpy.context, "Room") and not targets.is_room(bpy.context, "Cube")


class Base:
    """What an operator does after the click."""

    def __init__(self):
        self.started, self.properties = [], SimpleNamespace(is_property_set=lambda name: False)

    def invoke(self, context, event):
        self.started.append("at once")
        return {"RUNNING_MODAL"}

    def start_work(self, context, handled):
        self.started.append((tuple(self.location), handled))
        return {"RUNNING_MODAL"}


class Operator(PickPoint, Base):
    name = "Room"

    def target_name(self, context):
        return self.name


@pytest.fixture
def screen(monkeypatch):
    monkeypatch.setattr(bpy, "app", SimpleNamespace(background=False))
    made = Screen()
    made.window = SimpleNamespace(cursors=[])
    made.window.cursor_modal_set = made.window.cursors.append
    made.window.cursor_modal_restore = made.window.cursors.clear
    return made


def event(kind, value="PRESS"):
    return SimpleNamespace(type=kind, value=value, mouse_x=5, mouse_y=6)


def test_the_work_starts_at_the_click(screen, monkeypatch):
    places = [None, (1.0, 2.0, 3.0)]
    monkeypatch.setattr(targets, "point_under", lambda context, x, y, name: places.pop(0))
    operator = Operator()
    assert operator.invoke(screen, event("LEFTMOUSE")) == {"RUNNING_MODAL"} and not operator.started
    assert screen.window.cursors and "Room" in screen.status
    assert operator.modal(screen, event("MOUSEMOVE", "NOTHING")) == {"PASS_THROUGH"}
    operator.modal(screen, event("LEFTMOUSE"))  # beside the room
    assert not operator.started
    operator.modal(screen, event("LEFTMOUSE"))
    assert operator.started == [((1.0, 2.0, 3.0), True)]
    assert not screen.window.cursors and screen.status is None


@pytest.mark.parametrize("key", ["ESC", "RIGHTMOUSE"])
def test_nothing_starts_without_a_click(screen, key):
    operator = Operator()
    operator.invoke(screen, event("LEFTMOUSE"))
    assert operator.modal(screen, event(key)) == {"CANCELLED"}
    assert not operator.started and not screen.window.cursors and screen.status is None


def test_furniture_is_not_asked_about(screen):
    bpy.ops.mesh.primitive_cube_add(size=1)
    bpy.context.object.name = "Crate"
    operator = Operator()
    operator.name = "Crate"
    operator.invoke(screen, event("LEFTMOUSE"))
    assert operator.started == ["at once"]
