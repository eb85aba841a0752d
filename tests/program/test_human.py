"""The default human: its asset, and skinning that agrees with Blender's."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon import frames, rotation, skeleton
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.body import brows, hands, human
from samp_blender.samp_addon.motion import Motion
from samp_blender.tests.support.blender import rigs

MOCAP = Path(__file__).parents[3] / "shared" / "data" / "mocap" / "smplx30"


def test_asset_is_a_body():
    body = human.load()
    assert body.joints.shape == (55, 3) and np.allclose(body.joints[0], 0)
    assert len(body.collision) == 2048 == len(set(body.collision.tolist()))
    assert body.weights.shape == body.weight_joints.shape == (len(body.vertices), 4)
    assert np.allclose(body.weights.sum(1), 1) and body.weight_joints.max() == 54
    assert 1.6 < body.height < 1.75 and body.faces.max() == len(body.vertices) - 1
    assert np.isclose(body.vertices[:, 1].min(), body.floor)
    assert set(human.MATERIALS) == {human.MATERIALS[i] for i in np.unique(body.materials)}
    with pytest.raises(ValueError, match="read-only"):
        body.vertices[0] = 0


def test_left_and_right_mirror():
    joints = human.load().joints
    twins = [skeleton.INDEX[mirrored(name)] for name in skeleton.JOINTS]
    assert np.abs(joints[twins] * (-1, 1, 1) - joints).max() < 2e-3


def mirrored(name: str) -> str:
    return name.replace("left_", "@").replace("right_", "left_").replace("@", "right_")


def test_brows_are_over_both_eyes_alike_and_of_hair():
    body = human.load()
    found = brows.of(body.vertices, body.faces, body.joints)
    centres = body.vertices[body.faces].mean(axis=1)
    assert (body.materials[found] == human.MATERIALS.index("hair")).all()
    eyes = centres[body.materials == human.MATERIALS.index("eyes")]
    for sign in (1, -1):
        own = centres[found & (sign * centres[:, 0] > 0)]
        eye = eyes[sign * eyes[:, 0] > 0]
        assert len(own) == found.sum() / 2 >= 4
        assert np.ptp(own[:, 0]) > np.ptp(eye[:, 0]) and own[:, 1].min() > eye[:, 1].max()
        assert (own[:, 2] > eye[:, 2].mean()).all()


def test_every_edge_has_two_faces():
    faces = human.load().faces
    sides = np.concatenate([np.stack([faces[:, k], faces[:, (k + 1) % 4]], 1) for k in range(4)])
    sides = np.sort(sides[sides[:, 0] != sides[:, 1]], axis=1)
    body = sides[np.all(sides < 12272, axis=1)]  # the eyeballs' poles are degenerate
    _, uses = np.unique(body, axis=0, return_counts=True)
    assert (uses == 2).all()


@pytest.mark.skipif(not MOCAP.is_dir(), reason="the motion data is not available")
def test_joints_agree_with_the_motion_data():
    file = sorted(MOCAP.glob("*.npz"))[0]
    with np.load(file) as data:
        assert np.abs(human.load().joints[:22] - data["rest_joints"]).max() < 1e-3


@pytest.mark.parametrize(
    ("shape", "taller"), [("tall", 0.08), ("short", -0.08), ("male", 0.02), ("female", -0.05)]
)
def test_joints_follow_the_shape(shape, taller):
    body, other = human.load(), human.load().shaped({shape: 1.0})
    assert (other.height - body.height) * np.sign(taller) > abs(taller)
    head = skeleton.INDEX["head"]
    assert (other.joints[head, 1] - other.floor - body.joints[head, 1] + body.floor) * np.sign(taller) > 0


def test_skin_at_rest_and_moved():
    body = human.load()
    flat = np.tile([1.0, 0, 0, 0], (2, 55, 1))
    root = np.array([[0.0, 0, 0], [3.0, 2.0, 1.0]])
    shown = human.skin(body, Motion(root, flat))
    assert np.abs(shown - (body.vertices + root[:, None])).max() < 1e-5
    # A quarter turn counter-clockwise about the vertical maps +Z to +X.
    turned = flat.copy()
    turned[:, 0] = rotation.about_y(np.pi / 2)
    shown = human.skin(body, Motion(root, turned), chunk=1)[1] - root[1]
    assert np.abs(shown - body.vertices[:, [2, 1, 0]] * (1, 1, -1)).max() < 1e-5


@pytest.mark.parametrize("shapes", [{}, {"female": 1.0, "tall": 0.5}])
def test_blender_deforms_the_mesh_identically(shapes):
    scene = rigs.reset()
    armature = character.create_character(bpy.context, shapes, (1.0, -2.0, 0.5), 0.7)
    body = human.load().shaped(shapes)
    assert np.abs(character.body_of(armature).vertices - body.vertices).max() < 1e-5
    take = rigs.take(12, rest_joints=body.joints)
    keyframes.write_motion(armature, take)
    expected = human.skin(body, take)
    mesh = armature.children[0]
    for frame in (0, 5, 11):
        scene.frame_set(frame + 1)
        shown = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
        points = np.empty(len(shown.data.vertices) * 3)
        shown.data.vertices.foreach_get("co", points)
        world = np.array(shown.matrix_world)
        points = points.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]
        assert np.abs(frames.to_network(points) - expected[frame]).max() < 1e-4


def test_created_character_stands_on_the_floor():
    rigs.reset()
    armature = character.create_character(bpy.context, {"short": 1.0}, (2.0, 1.0, 0.25), np.pi / 2)
    mesh = armature.children[0]
    shown = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    heights = [(shown.matrix_world @ vertex.co).z for vertex in shown.data.vertices]
    assert abs(min(heights) - 0.25) < 2e-3
    assert mesh.data.shape_keys.key_blocks["short"].value == 1.0
    assert [key.value for key in mesh.data.shape_keys.key_blocks if key.name not in ("Basis", "short")] == [
        0.0
    ] * 7
    assert all(slot.material is not None for slot in mesh.material_slots)
    assert len(armature.data.bones) == 56 and bpy.context.view_layer.objects.active == armature
    # Yaw of a quarter turn left from -Y looks to +X, which is the network's +X as well.
    assert armature.matrix_world.to_euler().z == pytest.approx(np.pi / 2)


def test_relaxed_fingers_bend_towards_the_palm():
    flat = np.tile([1.0, 0, 0, 0], (1, 22, 1))
    positions, _ = skeleton.forward_kinematics(np.zeros((1, 3)), hands.complete(flat), human.load().joints)
    rest = human.load().joints
    for side in ("left", "right"):
        for finger in ("index", "middle", "ring", "pinky"):
            tip = skeleton.INDEX[f"{side}_{finger}3"]
            assert positions[0, tip, 1] < rest[tip, 1] - 0.005  # palms face the floor in the T-pose
    assert hands.complete(np.ones((3, 55, 4))).shape == (3, 55, 4)
