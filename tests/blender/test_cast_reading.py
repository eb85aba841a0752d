"""What a cast reads of the scene: bodies that are not of it, whatever moves them, and the pieces of a set."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon.blender.cast import furniture, others, reading
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.pipeline.cast.cast import Cast, Member
from samp_blender.samp_addon.pipeline.job import Job

CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


@pytest.fixture(autouse=True)
def _empty_scene():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def box(name, low, size, parent=None):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(np.add(low, np.multiply(c, size))) for c in CORNERS], [], FACES)
    obj = bpy.data.objects.new(name, mesh)
    obj.parent = parent
    bpy.context.scene.collection.objects.link(obj)
    return obj


def person(name, moves):
    """A body of another origin: a box that a rig without SMPL-X bones deforms, moved along X if wanted."""
    rig = bpy.data.objects.new(name, bpy.data.armatures.new(name))
    bpy.context.scene.collection.objects.link(rig)
    body = box(f"{name} body", (-0.2, -0.2, 0), (0.4, 0.4, 1.7), rig)
    body.modifiers.new("Armature", "ARMATURE").object = rig
    if moves:
        for frame, x in ((1, 0.0), (49, 4.0)):
            rig.location.x = x
            rig.keyframe_insert("location", index=0, frame=frame)
    return rig


def member(**options):
    return Member(Job(**({"action": "walk", "to": (1, 2, 0), "start": (0, -2, 0, 0)} | options)), "Ann")


def test_moving_bodies_are_no_furniture_but_are_there_over_time():
    box("Floor", (-5, -5, -0.1), (10, 10, 0.1))
    person("Still", False)
    person("Crowd", True)
    bpy.context.scene.frame_set(30)
    plan = reading.read(bpy.context, Cast((member(),)))
    assert "Crowd body" not in plan.geometry.names and "Still body" in plan.geometry.names
    (other,) = plan.work.others
    assert other.name == "Crowd"
    middle = other.track.centres.mean(1)
    assert middle[0] == pytest.approx([0, 0.85, 0], abs=0.2)
    assert middle[-1] == pytest.approx([4, 0.85, 0], abs=0.2)
    assert len(other.track) == pytest.approx(48 / 24 * other.track.rate + 1, abs=1)
    assert bpy.context.scene.frame_current == 30


def test_nobody_else():
    box("Floor", (-5, -5, -0.1), (10, 10, 0.1))
    assert others.read(bpy.context, []) == []


def test_pieces_of_a_set():
    dining = bpy.data.objects.new("Dining", None)
    bpy.context.scene.collection.objects.link(dining)
    for k in range(2):
        chair = box(f"Chair {k}", (k, 0, 0), (0.4, 0.4, 0.9), dining)
        box(f"Cushion {k}", (k, 0, 0.45), (0.4, 0.4, 0.08), chair)
    box("Lamp shade", (0, 3, 1.5), (0.4, 0.4, 0.5), dining)
    sofa = bpy.data.objects.new("Sofa", None)
    bpy.context.scene.collection.objects.link(sofa)
    box("Frame", (5, 0, 0), (2, 0.8, 0.8), sofa)
    box("Seat cushion", (5, 0, 0.4), (2, 0.8, 0.15), sofa)
    bpy.context.view_layer.update()
    assert furniture.pieces(bpy.context, "Dining") == ("Chair 0", "Chair 1")
    assert furniture.pieces(bpy.context, "Sofa") == ("Sofa",)
    assert furniture.pieces(bpy.context, "Chair 0") == ("Chair 0",)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (member(character="Nobody"), "'Ann': The scene has no object 'Nobody'"),
        (member(action="sit", target="Flor", to=None), "'Ann': There is no 'Flor' in the scene"),
    ],
)
def test_errors_name_the_member(made, message):
    box("Floor", (-5, -5, -0.1), (10, 10, 0.1))
    with pytest.raises(SampError, match=message):
        reading.read(bpy.context, Cast((made,)))


def test_there_is_nothing_of_that_name_to_look_at():
    box("Floor", (-5, -5, -0.1), (10, 10, 0.1))
    job = Job(action="walk", to=(1, 2, 0), start=(0, -2, 0, 0))
    with pytest.raises(SampError, match="'Ann': There is no 'Lampe' to look at"):
        reading.read(bpy.context, Cast((Member(job, "Ann", look_at="Lampe"),)))
