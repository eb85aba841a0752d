"""Several characters at once: Sit Here with several selected, the cast list, Look At."""

from __future__ import annotations

import bpy
import fakes
import numpy as np
import pytest
import rooms
from boxes import add_boxes
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.methods.samp import networks

PLACES = {"Ann": (-1.5, 0.0), "Bob": (0.0, 0.8), "Cid": (1.5, 0.0)}


pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _fake_networks(monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    add_boxes("Floor", [((-4, -0.1, -4), (4, 0, 4))], (0, 0, 0))
    for k, x in enumerate((-1.2, 0.0, 1.2)):
        add_boxes(f"Chair {k}", rooms.chair(np.random.default_rng(k)), (x, 2.5, 0))
    bpy.context.view_layer.update()
    for name, (x, y) in PLACES.items():
        character.create_character(bpy.context, location=(x, y - 2, 0), yaw=np.pi, name=name)
    return bpy.context.scene


def select(*names):
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    for name in names:
        bpy.data.objects[name].select_set(True)
    bpy.context.view_layer.objects.active = bpy.data.objects[names[-1]]


def active(name):
    data = bpy.data.objects[name].animation_data
    return None if data is None else data.action


def ends():
    """Where the pelvises of all characters are in the end."""
    bpy.context.scene.frame_set(1000)
    owners = [bpy.data.objects[name] for name in PLACES]
    return np.array([owner.matrix_world @ owner.pose.bones["pelvis"].head for owner in owners])


def on_chairs():
    """The number of the chair that each character is on in the end, in order."""
    return sorted(int(np.abs(x - np.array([-1.2, 0.0, 1.2])).argmin()) for x in ends()[:, 0])


def matrices():
    return {obj.name: np.array(obj.matrix_world) for obj in bpy.data.objects}


def test_each_takes_a_chair_of_its_own(scene):
    select(*PLACES, "Chair 0", "Chair 1", "Chair 2")
    before = matrices()
    assert bpy.ops.samp.sit_here(hold=0.5) == {"FINISHED"}
    assert len({active(name) for name in PLACES}) == len(bpy.data.actions) == 3
    assert on_chairs() == [0, 1, 2]
    assert all(np.array_equal(before[name], now) for name, now in matrices().items() if name in before)
    assert set(before) == set(matrices())


def test_fewer_chairs_than_characters(scene):
    select(*PLACES, "Chair 0", "Chair 1")
    assert bpy.ops.samp.sit_here(hold=0.5) == {"FINISHED"}
    assert len(bpy.data.actions) == 2


def test_a_seat_that_is_taken_is_not_free(scene):
    select("Ann")
    bpy.ops.samp.sit_here(character="Ann", target="Chair 1", hold=0.5)
    select("Bob", "Cid", "Chair 0", "Chair 1", "Chair 2")
    bpy.ops.samp.sit_here(hold=0.5)
    assert on_chairs() == [0, 1, 2]


def test_walking_together_ends_beside_each_other(scene):
    select(*PLACES)
    assert bpy.ops.samp.walk_here(location=(0.0, 1.2, 0.0), hold=0.5) == {"FINISHED"}
    points = ends()[:, :2]
    gaps = np.linalg.norm(points[:, None] - points[None], axis=-1)[np.triu_indices(3, 1)]
    assert gaps.min() > 0.5  # the stand-ins' bodies have their arms out and make more room


def test_the_cast_list(scene):
    settings = scene.samp
    select("Ann", "Bob", "Chair 0", "Chair 2")
    settings.action = "sit"
    assert bpy.ops.samp.edit_cast(change="ADD") == {"FINISHED"}
    assert [member.character.name for member in settings.cast] == ["Ann", "Bob"]
    assert {member.target.name for member in settings.cast} == {"Chair 0", "Chair 2"}
    select("Floor")
    bpy.ops.samp.edit_cast(change="ADD")
    new = settings.cast[2]
    new.name, new.action, new.place, new.delay = "Dora", "walk", (3.0, 0.0, 0.0), 2.0
    new.use_start, new.start = True, (3.0, -3.0, 0.0)
    bpy.ops.samp.edit_cast(change="UP")
    assert [member.name for member in settings.cast][1] == "Dora"
    bpy.ops.samp.edit_cast(change="DOWN")
    settings.hold = 0.5
    assert bpy.ops.samp.bake_cast() == {"FINISHED"}
    owner = bpy.data.objects["Dora"]
    take = keyframes.read_motion(owner, owner.animation_data.action)
    standing = np.linalg.norm(take.root - take.root[0], axis=-1) < 0.05
    assert standing[: int(1.9 * take.fps)].all()
    assert active("Ann") is not None and active("Bob") is not None and active("Cid") is None
    bpy.ops.samp.edit_cast(change="REMOVE")
    assert len(settings.cast) == 2


def test_an_empty_cast_cannot_be_baked(scene):
    assert not bpy.ops.samp.bake_cast.poll()


def test_look_at(scene):
    select("Ann")
    bpy.ops.samp.sit_here(character="Ann", target="Chair 0", hold=1.0)
    before, first = active("Ann"), active("Ann").copy()
    assert bpy.ops.samp.look_at(character="Ann", target="Chair 2") == {"FINISHED"}
    assert active("Ann") != before
    owner = bpy.data.objects["Ann"]
    old, new = (keyframes.read_motion(owner, action) for action in (before, active("Ann")))
    assert np.array_equal(old.root, new.root)
    assert np.abs(old.rotations[-1, 15] - new.rotations[-1, 15]).max() > 0.05
    kept = keyframes.read_motion(owner, first)
    assert np.array_equal(kept.rotations, old.rotations)  # the take itself is as it was


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"target": "Nothing"}, "There is no 'Nothing'"),
        ({"target": "Ann"}, "cannot look at itself"),
        ({"target": "Chair 1", "use_range": True, "frame_start": 9000, "frame_end": 9001}, "no frames"),
    ],
)
def test_look_at_refuses(scene, options, message):
    select("Ann")
    bpy.ops.samp.sit_here(character="Ann", target="Chair 0", hold=0.2)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.samp.look_at(character="Ann", **options)
