"""Creates the default human: a skinned mesh on a 55-bone SMPL-X armature."""

from __future__ import annotations

from collections.abc import Mapping

import bpy
import numpy as np

from ... import frames, rotation, skeleton
from ...body import body_shape, human
from ...body.hands import relaxed_hands
from ...body.human import SIZE, Human
from .. import compat
from . import materials, start
from .armature import calibrate, standing_floor

# Custom property of an armature created here: its body shape.
SHAPES = "samp_shapes"
_ROOT_LENGTH = 0.1
# Joints whose bone ends at another joint than its only child, or in a direction (network axes, metres).
_ENDS_AT = {
    "pelvis": "spine1",
    "spine3": "neck",
    "left_wrist": "left_middle1",
    "right_wrist": "right_middle1",
}
_TIPS = {
    "head": (0.0, 0.16, 0.0),
    "jaw": (0.0, -0.03, 0.06),
    "left_eye_smplhf": (0.0, 0.0, 0.02),
    "right_eye_smplhf": (0.0, 0.0, 0.02),
    "left_foot": (0.0, 0.0, 0.08),
    "right_foot": (0.0, 0.0, 0.08),
}
_FINGERTIP = 0.8
"""Length of a finger's last bone relative to the bone before it."""
# Standing pose of the left side, rotation vectors in degrees, network axes; mirrored for the right side.
_STANDING = {"shoulder": (0.0, 0.0, -66.0), "elbow": (0.0, -16.0, 0.0), "collar": (0.0, 0.0, -6.0)}


def create_character(
    context: bpy.types.Context,
    shapes: dict[str, float] | None = None,
    location: tuple[float, float, float] = (0.0, 0.0, 0.0),
    yaw: float = 0.0,
    name: str = "Human",
    look: str = "",
) -> bpy.types.Object:
    """Create the human and return its armature, which becomes the active object.

    shapes: weights of the body shapes (male, female, tall, short, ...), 0 to 1 or more, applied to the mesh's shape
    keys and the joints; see body/body_shape.py. location: of the soles, metres, Blender's world. yaw: radians, 0 faces
    -Y, positive turns left. look: a name of materials.LOOKS; if empty, the one that the fewest humans have. Bones run
    from joint to joint, so their axes are not SMPL-X's: see armature.calibrate.
    """
    shapes = {key: value for key, value in (shapes or {}).items() if value}
    default, body = human.load(), human.load().shaped(shapes)
    lift = np.array([0.0, -body.floor, 0.0])  # the objects' origin lies between the soles
    armature = _armature(context, body.joints + lift, name)
    look = look or materials.next_look()
    mesh = _mesh(context, default, lift, shapes, f"{name} mesh", look)
    _bind(mesh, armature, default)
    armature.location, armature.rotation_euler = location, (0.0, 0.0, yaw)
    armature[SHAPES], armature[materials.LOOK_KEY] = shapes, look
    pose_standing(armature)
    for obj in context.selected_objects:
        obj.select_set(False)
    armature.select_set(True)
    context.view_layer.objects.active = armature
    context.view_layer.update()
    start.store(armature, standing_floor(armature))
    return armature


def shapes_for(measures: Mapping[str, float], more: Mapping[str, float]) -> dict[str, float]:
    """Return the weights of the body shapes for measures by name, and more weights added to them. Raise SampError."""
    body_shape.check(measures)
    shapes = body_shape.shapes(measures)
    return shapes | {name: shapes.get(name, 0.0) + value for name, value in more.items() if value}


def pose_standing(armature: bpy.types.Object) -> None:
    """Pose an armature created here with arms down and fingers relaxed. No keyframes."""
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (len(skeleton.JOINTS), 1))
    quaternions[skeleton.BODY_COUNT :] = relaxed_hands()
    for joint, degrees in _STANDING.items():
        for side, mirror in (("left", (1, 1, 1)), ("right", (1, -1, -1))):
            vector = np.radians(np.array(degrees) * mirror)
            quaternions[skeleton.INDEX[f"{side}_{joint}"]] = rotation.from_axis_angle(vector)
    calibration = calibrate(armature)
    own = rotation.change_basis(
        rotation.change_basis(quaternions, calibration.axes), np.swapaxes(calibration.bases, 1, 2)
    )
    for j, bone in enumerate(calibration.bones):
        armature.pose.bones[bone].rotation_quaternion = own[j]


def body_of(armature: bpy.types.Object) -> Human:
    """Return the body to measure an armature's takes with: the default human in the armature's shape and size.

    For an armature from elsewhere the default human is fitted to the armature's bones.
    """
    joints = calibrate(armature).rest_joints
    return human.load().shaped(shapes_of(armature)).with_joints(joints)


def shapes_of(armature: bpy.types.Object) -> dict[str, float]:
    """Return the weights of the body shapes of an armature created here; empty for one from elsewhere."""
    shapes = armature.get(SHAPES)
    return {} if shapes is None else shapes.to_dict()


def has_surface(context: bpy.types.Context, armature: bpy.types.Object) -> bool:
    """Return whether the armature deforms a mesh with faces."""
    meshes = (obj for obj in context.scene.objects if obj.type == "MESH" and obj.data.polygons)
    return any(mesh.find_armature() == armature for mesh in meshes)


def _armature(context: bpy.types.Context, joints: np.ndarray, name: str) -> bpy.types.Object:
    """Create an armature with rest joints (55, 3) in the network frame; bones run from joint to joint."""
    data = bpy.data.armatures.new(name)
    data.display_type = "STICK"
    armature = bpy.data.objects.new(name, data)
    _link(context, armature)
    context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    heads, tails = frames.to_blender(joints), frames.to_blender(_tails(joints))
    root = data.edit_bones.new("root")
    root.head, root.tail = (0.0, 0.0, 0.0), (0.0, 0.0, _ROOT_LENGTH)
    for j, joint in enumerate(skeleton.JOINTS):
        bone = data.edit_bones.new(joint)
        bone.head, bone.tail = heads[j], tails[j]
        bone.align_roll(_roll_axis(heads[j], tails[j]))
        bone.parent = data.edit_bones[skeleton.JOINTS[skeleton.PARENTS[j]]] if j else root
    bpy.ops.object.mode_set(mode="OBJECT")
    data.bones["root"].use_deform = False
    _sort_bones(data)
    for bone in armature.pose.bones:
        bone.rotation_mode = "QUATERNION"
    return armature


def _tails(joints: np.ndarray) -> np.ndarray:
    """Return the tails (55, 3) of the bones for rest joints (55, 3), network frame."""
    tails = joints.copy()
    for j, joint in enumerate(skeleton.JOINTS):
        children = [k for k, parent in enumerate(skeleton.PARENTS) if parent == j and k]
        if joint in _TIPS:
            tails[j] = joints[j] + _TIPS[joint]
        elif joint in _ENDS_AT:
            tails[j] = joints[skeleton.INDEX[_ENDS_AT[joint]]]
        elif children:
            tails[j] = joints[children[0]]
        else:
            tails[j] = joints[j] + _FINGERTIP * (joints[j] - joints[skeleton.PARENTS[j]])
    return tails


def _roll_axis(head: np.ndarray, tail: np.ndarray) -> tuple[float, float, float]:
    """Return the direction of a bone's Z axis: forward (-Y in Blender), or up for bones that point forward."""
    along = (tail - head) / np.linalg.norm(tail - head)
    return (0.0, 0.0, 1.0) if abs(along[1]) > 0.7 else (0.0, -1.0, 0.0)


def _sort_bones(data: bpy.types.Armature) -> None:
    """Assign bones to collections, so that e.g. the fingers can be hidden."""
    groups = {key: data.collections.new(key) for key in ("Body", "Face", "Left hand", "Right hand")}
    for bone in data.bones:
        j = skeleton.INDEX.get(bone.name, 0)
        key = "Body" if j < 22 else "Face" if j < 25 else "Left hand" if j < 40 else "Right hand"
        groups[key].assign(bone)


def _mesh(
    context: bpy.types.Context, body: Human, lift: np.ndarray, shapes: dict[str, float], name: str, look: str
) -> bpy.types.Object:
    """Create the mesh object with its materials and shape keys, offset by ``lift`` (3,)."""
    data = bpy.data.meshes.new(name)
    faces = [face[:3] if face[2] == face[3] else face for face in body.faces.tolist()]
    data.from_pydata(frames.to_blender(body.vertices + lift).tolist(), [], faces)
    for material in materials.body_materials(look):
        data.materials.append(material)
    data.polygons.foreach_set("material_index", body.materials.astype(np.int32))
    data.polygons.foreach_set("use_smooth", np.ones(len(faces), dtype=bool))
    data.update()
    mesh = bpy.data.objects.new(name, data)
    _link(context, mesh)
    compat.new_shape_key(mesh, "Basis")
    for key, (offset, _) in body.shapes.items():
        block = compat.new_shape_key(mesh, key, shapes.get(key, 0.0))
        points = frames.to_blender(body.vertices + lift + offset)
        block.data.foreach_set("co", points.astype(np.float32).ravel())
    if shapes.get(SIZE):  # as it is for these shapes
        block = compat.new_shape_key(mesh, SIZE, 1.0)
        points = body.vertices + lift + body.shaped(shapes).vertices
        points = points - body.shaped({key: value for key, value in shapes.items() if key != SIZE}).vertices
        block.data.foreach_set("co", frames.to_blender(points).astype(np.float32).ravel())
    return mesh


def _bind(mesh: bpy.types.Object, armature: bpy.types.Object, body: Human) -> None:
    """Add vertex groups, parent and Armature modifier: linear blend skinning as in body/human.py."""
    groups = [mesh.vertex_groups.new(name=joint) for joint in skeleton.JOINTS]
    for k in range(body.weights.shape[1]):
        used = np.flatnonzero(body.weights[:, k] > 0)
        for vertex, joint, weight in zip(
            used.tolist(), body.weight_joints[used, k].tolist(), body.weights[used, k].tolist(), strict=True
        ):
            groups[joint].add((vertex,), weight, "ADD")
    mesh.parent = armature
    modifier = mesh.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    modifier.use_deform_preserve_volume = False


def _link(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Link an object to the active collection, or to the scene collection if that one cannot be edited."""
    collection = context.collection
    if collection is None or not collection.is_editable or obj.name in collection.objects:
        collection = context.scene.collection
    collection.objects.link(obj)
