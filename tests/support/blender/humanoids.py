"""Rigs as imported from other programs: names, hierarchy, rest pose and bone axes."""

from __future__ import annotations

import functools
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix
from samp_blender.samp_addon import frames, rotation, skeleton
from samp_blender.samp_addon.rigs import maps


@dataclass(frozen=True)
class Family:
    """A family of rigs.

    known: name under which it is recognised. names: joint -> bone; parents: bone -> bone. extra: bones without a joint
    -> (parent, joint, another joint, fraction of the distance between them). arms: degrees of the arms below the
    T-pose. legs, width: leg length and hip width relative to the default body. unit: metres. upright: whether the
    armature's own up axis is Y. along: the bone axis that points along the bone.
    """

    known: str
    names: dict[str, str]
    parents: dict[str, str]
    extra: dict[str, tuple[str | None, str, str, float]] = field(default_factory=dict)
    arms: float = 0.0
    legs: float = 1.0
    width: float = 1.0
    unit: float = 1.0
    upright: bool = False
    along: str = "Y"


def _known(name: str, prefix: str = "") -> dict[str, str]:
    rig = next(rig for rig in maps.KNOWN if rig.name == name)
    return {joint: prefix + names[0] for joint, names in rig.bones.items()}


def _hierarchy(names: dict[str, str], **changes: str) -> dict[str, str]:
    """Return bone -> parent as in SMPL-X, with changes."""
    result = {}
    for joint, bone in names.items():
        above = skeleton.PARENTS[skeleton.INDEX[joint]]
        while above >= 0 and skeleton.JOINTS[above] not in names:
            above = skeleton.PARENTS[above]
        if above >= 0:
            result[bone] = names[skeleton.JOINTS[above]]
    return result | changes


_UE4, _UE5 = _known("Unreal 4 mannequin"), _known("Unreal 5 mannequin")
_TWISTS = {
    f"{bone}_twist_01_{mark}": (f"{bone}_{mark}", f"{side}_{start}", f"{side}_{end}", 0.5)
    for side, mark in (("left", "l"), ("right", "r"))
    for bone, start, end in (
        ("upperarm", "shoulder", "elbow"),
        ("lowerarm", "elbow", "wrist"),
        ("thigh", "hip", "knee"),
    )
}
_IK = {
    "root": (None, "floor", "floor", 0.0),
    "ik_foot_root": ("root", "floor", "floor", 0.0),
    "ik_foot_l": ("ik_foot_root", "left_ankle", "left_ankle", 0.0),
    "ik_foot_r": ("ik_foot_root", "right_ankle", "right_ankle", 0.0),
}


def _mixamo(prefix: str) -> Family:
    names = _known("Mixamo", prefix)
    tops = {f"{prefix}HeadTop_End": (names["head"], "head", "neck", -1.0)}
    return Family("Mixamo", names, _hierarchy(names), tops, legs=1.07, unit=0.01, upright=True)


_STRANGE = {
    "pelvis": "Bip Pelvis",
    "spine1": "Bip Spine",
    "spine3": "Bip Chest",
    "neck": "Bip Neck",
    "head": "Bip Head",
} | {
    f"{side}_{joint}": f"Bip {side[0].upper()} {bone}"
    for side in ("left", "right")
    for joint, bone in (
        ("hip", "Thigh"),
        ("knee", "Calf"),
        ("ankle", "Foot"),
        ("foot", "Toe0"),
        ("collar", "Clavicle"),
        ("shoulder", "UpperArm"),
        ("elbow", "Forearm"),
        ("wrist", "Hand"),
    )
}
FAMILIES = {
    "mixamo": _mixamo("mixamorig:"),
    "mixamo without prefix": _mixamo(""),
    "mixamo numbered": _mixamo("mixamorig12:"),
    "unreal 4": Family(
        "Unreal 4 mannequin",
        _UE4,
        _hierarchy(_UE4, pelvis="root"),
        _TWISTS | _IK,
        arms=48.0,
        legs=1.12,
        width=1.2,
        along="X",
    ),
    "unreal 5": Family(
        "Unreal 5 mannequin",
        _UE5,
        _hierarchy(_UE5, pelvis="root", spine_03="spine_02", spine_05="spine_04", head="neck_02"),
        _TWISTS
        | _IK
        | {
            "spine_02": ("spine_01", "spine1", "spine2", 0.5),
            "spine_04": ("spine_03", "spine2", "spine3", 0.5),
            "neck_02": ("neck_01", "neck", "head", 0.5),
        },
        arms=55.0,
        legs=0.9,
        unit=0.01,
        along="X",
    ),
    "strange": Family("", _STRANGE, _hierarchy(_STRANGE), arms=30.0, legs=0.95, along="Z"),
}


def rest_joints(family: Family) -> dict[str, np.ndarray]:
    """Return joint positions (3,) in the rig's rest pose, network frame, soles on the ground."""
    ours = skeleton.default_rest_joints()
    places, turns = {}, {}
    for j, joint in enumerate(skeleton.JOINTS):
        above = skeleton.PARENTS[j]
        if above < 0:
            places[joint], turns[joint] = np.zeros(3), np.array([1.0, 0, 0, 0])
            continue
        parent = skeleton.JOINTS[above]
        way = ours[j] - ours[above]
        if joint.endswith(("_knee", "_ankle")):
            way = way * family.legs
        if joint.endswith("_hip"):
            way = way * [family.width, 1, 1]
        places[joint] = places[parent] + rotation.rotate(turns[parent], way)
        turns[joint] = turns[parent]
        if joint.endswith("_shoulder"):
            side = 1 if joint.startswith("left") else -1
            hang = rotation.from_axis_angle(np.radians([0.0, 12.0 * side, -family.arms * side]))
            turns[joint] = rotation.multiply(turns[parent], hang)
    ground = np.mean([places[f"{side}_foot"][1] for side in ("left", "right")]) - 0.0276
    places = {joint: place - [0, ground, 0] for joint, place in places.items()}
    return places | {"floor": np.zeros(3)}


def _end(joint: str, places: dict[str, np.ndarray], family: Family) -> np.ndarray:
    """Return the tail of a joint's bone: the next joint, or a short extension."""
    nexts = {"hip": "knee", "knee": "ankle", "ankle": "foot", "shoulder": "elbow", "elbow": "wrist"}
    nexts |= {"collar": "shoulder", "wrist": "middle1"}
    trunk = {"pelvis": "spine1", "spine1": "spine2", "spine2": "spine3", "spine3": "neck", "neck": "head"}
    if joint in trunk:
        return places[trunk[joint]]
    side, _, part = joint.partition("_")
    if part in nexts:
        return places[f"{side}_{nexts[part]}"]
    if part == "foot":
        return places[joint] + [0, 0, 0.06]
    if part and part[-1] in "12":
        return places[f"{side}_{part[:-1]}{int(part[-1]) + 1}"]
    above = skeleton.JOINTS[skeleton.PARENTS[skeleton.INDEX[joint]]]
    return places[joint] + 0.7 * (places[joint] - places[above])


def make(kind: str, name: str = "Rig") -> bpy.types.Object:
    """Create a rig of a family of FAMILIES, in its rest pose, without an Action."""
    family = FAMILIES[kind]
    places = rest_joints(family)
    bones = {
        bone: (places[joint], _end(joint, places, family), family.parents.get(bone))
        for joint, bone in family.names.items()
    }
    for bone, (parent, start, end, share) in family.extra.items():
        place = places[start] + share * (places[end] - places[start])
        bones[bone] = (place, place + [0, 0.05, 0], parent)
    data = bpy.data.armatures.new(name)
    armature = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    to_own = np.eye(3) if family.upright else frames.BLENDER_FROM_NETWORK
    for k, (bone, (start, tip, _)) in enumerate(bones.items()):
        made = data.edit_bones.new(bone)
        head, end = to_own @ start / family.unit, to_own @ tip / family.unit
        made.head, made.tail = head, head + [0, 0.1, 0]
        made.matrix = Matrix.Translation(head) @ Matrix(_axes(end - head, family.along, k)).to_4x4()
        made.length = float(np.linalg.norm(end - head))
    for bone, (_, _, parent) in bones.items():
        data.edit_bones[bone].parent = data.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    armature.scale = (family.unit,) * 3
    armature.rotation_euler = (np.pi / 2 if family.upright else 0.0, 0.0, 0.0)
    bpy.context.view_layer.update()
    return armature


def _axes(way: np.ndarray, along: str, k: int) -> np.ndarray:
    """Return a bone's rest axes (3, 3): one along the bone, with a different roll for each bone.

    For Unreal's axes every second bone points the other way.
    """
    y = way / np.linalg.norm(way)
    x = np.cross(y, [0.3, 0.2, 1.0])
    x /= np.linalg.norm(x)
    frame = np.stack([x, y, np.cross(x, y)], axis=1)
    roll = rotation.quaternion_to_matrix(rotation.from_axis_angle(0.7 * k * y))
    frame = roll @ frame
    if along == "Y":
        return frame
    turn = {"X": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], "Z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]]}[along]
    return frame @ np.array(turn, dtype=float) @ np.diag([1, 1, 1] if k % 2 else [-1, -1, 1])


_MAKE_RIGIFY = """
import os, sys
import bpy, addon_utils
addon_utils.enable("rigify", default_set=True)
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
for kind, add in (
    ("metarig", bpy.ops.object.armature_basic_human_metarig_add),
    ("basic", bpy.ops.object.armature_basic_human_metarig_add),
    ("full", bpy.ops.object.armature_human_metarig_add),
):
    bpy.ops.object.select_all(action="DESELECT")
    add()
    if kind != "metarig":
        bpy.ops.pose.rigify_generate()
    bpy.context.object.name = kind
    bpy.ops.object.mode_set(mode="OBJECT")
bpy.data.libraries.write(sys.argv[1], {bpy.data.objects[kind] for kind in ("metarig", "basic", "full")})
os._exit(0)
"""


@functools.cache
def _rigify_file() -> Path:
    """Return a file with Rigify humans, made in a separate process: older versions crash at exit with Rigify on."""
    path = Path(tempfile.mkdtemp()) / "rigify.blend"
    command = [sys.executable, "-c", _MAKE_RIGIFY, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert path.exists(), done.stdout + done.stderr
    return path


def rigify(kind: str) -> bpy.types.Object:
    """Load a Rigify human: "metarig", or the generated "basic" or "full" rig."""
    with bpy.data.libraries.load(str(_rigify_file())) as (_, wanted):
        wanted.objects = [kind]
    rig = wanted.objects[0]
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.update()
    return rig


def dress(armature: bpy.types.Object, bones: dict[str, str], floor: float = 0.0) -> bpy.types.Object:
    """Add a stick body to a rig: a bar for each joint's bone, shoes to the floor (metres under the rig's origin)."""
    world = np.array(armature.matrix_world)
    points, faces, groups = [], [], {}
    rest = {
        joint: world[:3, :3] @ np.array(armature.data.bones[bone].head_local) + world[:3, 3]
        for joint, bone in bones.items()
    }
    for joint, bone in bones.items():
        tip = _tip(joint, rest)
        if tip is None:
            continue
        thick = 0.012 if joint[-1].isdigit() and not joint.startswith("spine") else 0.045
        corners = _bar(rest[joint], tip, thick)
        if joint.endswith(("_ankle", "_foot")):
            ahead = tip - rest[joint]
            ahead[2] = 0
            corners = _shoe(rest[joint], tip, ahead / np.linalg.norm(ahead), floor, joint.endswith("_ankle"))
        groups[bone] = range(len(points), len(points) + 8)
        faces += [[len(points) + k for k in face] for face in _BOX]
        points += corners.tolist()
    mesh = bpy.data.meshes.new("Sticks")
    mesh.from_pydata(points, [], faces)
    body = bpy.data.objects.new("Sticks", mesh)
    bpy.context.scene.collection.objects.link(body)
    for bone, indices in groups.items():
        body.vertex_groups.new(name=bone).add(list(indices), 1.0, "REPLACE")
    body.parent = armature
    body.matrix_parent_inverse = armature.matrix_world.inverted()
    modifier = body.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    return body


_BOX = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def _tip(joint: str, rest: dict[str, np.ndarray]) -> np.ndarray | None:
    """Return the end of a joint's bar."""
    below = [name for name in rest if name in skeleton.INDEX and skeleton.PARENTS[skeleton.INDEX[name]] >= 0]
    children = [name for name in below if skeleton.JOINTS[skeleton.PARENTS[skeleton.INDEX[name]]] == joint]
    wanted = {"pelvis": "spine1", "spine3": "neck"}.get(joint)
    if wanted in rest:
        return rest[wanted]
    if joint.endswith("wrist"):
        children = [name for name in children if "middle" in name]
    if children:
        return rest[children[0]]
    if joint == "head":
        return rest[joint] + [0, 0, 0.2]
    if joint.endswith("foot"):
        ankle = joint.replace("foot", "ankle")
        way = (rest[joint] - rest[ankle]) * [1, 1, 0]
        return rest[joint] + 0.06 * way / np.linalg.norm(way)
    above = skeleton.JOINTS[skeleton.PARENTS[skeleton.INDEX[joint]]]
    return None if above not in rest else rest[joint] + 0.6 * (rest[joint] - rest[above])


def _bar(start: np.ndarray, end: np.ndarray, thick: float) -> np.ndarray:
    along = (end - start) / max(np.linalg.norm(end - start), 1e-9)
    across = np.cross(along, [0.1, 0.9, 0.2])
    across /= np.linalg.norm(across)
    other = np.cross(along, across)
    return np.array(
        [at + a * thick * across + b * thick * other for at in (start, end) for a in (-1, 1) for b in (-1, 1)]
    )


def _shoe(start: np.ndarray, end: np.ndarray, ahead: np.ndarray, floor: float, heel: bool) -> np.ndarray:
    across = np.array([-ahead[1], ahead[0], 0.0]) * 0.04
    start = start - (0.05 * ahead if heel else 0)
    return np.array(
        [
            [*(at + a * across)[:2], floor if b < 0 else at[2]]
            for at in (start, end)
            for a in (-1, 1)
            for b in (-1, 1)
        ]
    )
