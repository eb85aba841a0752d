"""Place and Draw Path from Python, and one character beside others: what is there is respected."""

from __future__ import annotations

import math

import bpy
import fakes
import numpy as np
import pytest
from boxes import add_boxes
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.methods.samp import networks

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _fake_networks(monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    add_boxes("Floor", [((-4, -0.1, -4), (4, 0, 4))], (0, 0, 0))
    add_boxes("Bench", [((-1.2, 0, -0.25), (1.2, 0.45, 0.25))], (0, 2, 0))
    add_boxes("Stool", [((-0.2, 0, -0.2), (0.2, 0.45, 0.2))], (2.5, 0, 0))
    bpy.context.view_layer.update()
    character.create_character(bpy.context, location=(0, -2, 0), yaw=np.pi, name="Ann")
    bpy.context.scene.samp.character = bpy.data.objects["Ann"]
    bpy.context.scene.samp.hold = 0.5
    return bpy.context.scene


def take_of(name):
    owner = bpy.data.objects[name]
    return keyframes.read_motion(owner, owner.animation_data.action, scene=bpy.context.scene)


def test_a_place_on_a_seat_with_a_facing(scene):
    assert bpy.ops.samp.place(location=(0.6, 1.9, 0.45), use_yaw=True, yaw=0.0) == {"FINISHED"}
    motion = take_of("Ann")
    assert motion.root[-1, 0] == pytest.approx(0.6, abs=0.35)
    assert motion.headings()[-1] == pytest.approx([0, 0, 1], abs=0.02)  # -Y of Blender
    assert motion.root[-1, 1] == pytest.approx(0.63, abs=0.05)


def test_a_place_on_the_floor(scene):
    assert bpy.ops.samp.place(location=(-2, -1, 0)) == {"FINISHED"}
    assert take_of("Ann").root[-1, [0, 2]] == pytest.approx([-2, 1], abs=0.1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"location": (0, 0, 5)}, "There is nothing at this location"),
        ({"location": (0.0, 0.0, float("nan"))}, "There is nothing at this location"),
        ({"location": (2.5, 0, 0.45), "add_step": True, "use_yaw": True, "yaw": 0.0}, ""),
    ],
)
def test_why_not(scene, options, message):
    if not message:
        assert bpy.ops.samp.place(**options) == {"FINISHED"}
        return
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.samp.place(**options)


def test_steps_are_added_and_baked_exactly(scene):
    bpy.ops.samp.place(location=(2.5, 0, 0.45), use_yaw=True, yaw=math.pi / 2, add_step=True)
    bpy.ops.samp.place(location=(-0.6, 1.9, 0.45), use_yaw=True, yaw=0.0, add_step=True)
    steps = scene.samp.steps
    assert [(step.action, step.target.name, step.use_yaw) for step in steps] == [
        ("sit", "Stool", True),
        ("sit", "Bench", True),
    ]
    assert not bpy.data.actions
    assert bpy.ops.samp.bake_chain() == {"FINISHED"}
    motion = take_of("Ann")
    on_stool = np.linalg.norm(motion.root[:, [0, 2]] - [2.5, 0.0], axis=-1).min()
    assert on_stool < 0.1
    assert motion.root[-1, 0] == pytest.approx(steps[1].place[0], abs=0.05)


def test_somebody_sits_there_already(scene):
    assert bpy.ops.samp.place(location=(2.5, 0, 0.45)) == {"FINISHED"}
    character.create_character(bpy.context, location=(-1, -2, 0), yaw=np.pi, name="Bob")
    scene.samp.character = bpy.data.objects["Bob"]
    with pytest.raises(RuntimeError, match="'Ann' is already on 'Stool'"):
        bpy.ops.samp.place(location=(2.5, 0, 0.45))
    with pytest.raises(RuntimeError, match="'Ann' is already on 'Stool'"):
        bpy.ops.samp.sit_here(target="Stool", character="Bob")
    bpy.data.objects["Ann"].animation_data.action = None
    bpy.data.objects["Ann"].location = (-3, -3, 0)
    bpy.context.view_layer.update()
    assert bpy.ops.samp.sit_here(target="Stool", character="Bob") == {"FINISHED"}


def test_the_free_place_beside_somebody_is_taken(scene):
    bpy.ops.samp.sit_here(target="Bench", character="Ann")
    character.create_character(bpy.context, location=(-1, -2, 0), yaw=np.pi, name="Bob")
    bpy.ops.samp.sit_here(target="Bench", character="Bob")
    assert abs(take_of("Ann").root[-1, 0] - take_of("Bob").root[-1, 0]) > 0.42


def curve(name, points, kind="POLY"):
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.05
    spline = data.splines.new(kind)
    spline.points.add(len(points) - 1)
    for point, place in zip(spline.points, points, strict=True):
        point.co = (*place, 1)
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    obj.location = (0.5, 0, 0)
    bpy.context.view_layer.update()
    return obj


def test_a_curve_becomes_way_points(scene):
    curve("Way", [(-3, -2, 0), (-3, 0, 0), (-2, 1, 0)])
    before = {name: len(getattr(bpy.data, name)) for name in ("curves", "meshes")}
    assert bpy.ops.samp.draw_path(curve="Way") == {"FINISHED"}
    points = sorted((o for o in scene.objects if "samp_waypoint" in o), key=lambda o: o["samp_waypoint"])
    np.testing.assert_allclose(
        [tuple(o.location) for o in points], [(-2.5, -2, 0), (-2.5, 0, 0), (-1.5, 1, 0)], atol=1e-5
    )
    assert before == {name: len(getattr(bpy.data, name)) for name in before}
    bpy.ops.samp.sit_here(target="Bench", character="Ann")
    motion = take_of("Ann")
    for x, y, _ in (tuple(o.location) for o in points):
        assert np.linalg.norm(motion.root[:, [0, 2]] - [x, -y], axis=-1).min() < 0.3


@pytest.mark.parametrize(
    ("name", "message"),
    [("Wey", "There is no curve 'Wey'.*'Way'"), ("Floor", "'Floor' is no curve"), ("", "no line")],
)
def test_no_curve(scene, name, message):
    curve("Way", [(0, 0, 0), (1, 0, 0)])
    bpy.context.view_layer.objects.active = bpy.data.objects["Floor"]
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.samp.draw_path(curve=name)


def test_postures_of_a_place(scene):
    """After the plain way come the postures for which there is a place; the take and the step have the one chosen."""
    from samp_blender.samp_addon.blender.placing import reading
    from samp_blender.samp_addon.ui import job_from_settings

    owner = bpy.data.objects["Ann"]
    placer = reading.read(bpy.context, owner, job_from_settings.postures_at(bpy.context))
    count = reading.at_point(placer, (2.5, 0, 0.45)).choices
    stool = [reading.at_point(placer, (2.5, 0, 0.45), choice) for choice in range(count)]
    found = [spot.posture for spot in stool]
    assert found[-3:] == ["upright", "hands_on_lap", "legs_crossed"], "nothing to lean on"
    assert set(found[:-3]) == {""}, "the stool has four sides"
    job = job_from_settings.job_at(bpy.context, stool[-1])
    assert job.steps[0].settings["posture"] == "legs_crossed"
    assert not job_from_settings.job_at(bpy.context, stool[0]).steps[0].settings.get("posture")
    job_from_settings.add_step(bpy.context, stool[-3])
    assert job_from_settings.job_of_steps(bpy.context).steps[0].settings["posture"] == "upright"
