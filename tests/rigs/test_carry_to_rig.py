"""Takes on other rigs: every bone as Blender shows it, against the source take."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import bpy
import humanoids
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import frames, rotation, skeleton
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character, characters
from samp_blender.samp_addon.blender.rigs import bone_table, carry_to_rig, read_rig
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.blender.takes import baking
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.refine.feet import plan as foot_plan
from samp_blender.samp_addon.refine.proportions import carrying
from samp_blender.samp_addon.refine.proportions import hips as landmarks
from samp_blender.samp_addon.refine.proportions.footprints import Footprints
from samp_blender.samp_addon.rigs import maps, retargeting
from samp_blender.samp_addon.vocabulary import CONTACTS
from samp_blender.tests.support.blender import rigs

LEGS = [f"{side}_{joint}" for side in ("left", "right") for joint in ("hip", "knee", "ankle")]


pytestmark = pytest.mark.usefixtures("registered")


@functools.cache
def take() -> Motion:
    """Return a walk to a chair and a sit, as generated."""
    scene = rigs.reset()
    start = rooms.to_blender(rooms.random_room(3, rooms.chair), scene)
    made = baking.run(bpy.context, Job(action="sit", target="Chair", start=tuple(start)))
    return keyframes.read_motion(made.owner)


@functools.cache
def lying() -> Motion:
    """Return the end of the take tipped onto its back: feet in the air, hips unchanged."""
    part = carry_part(take(), slice(-20, None))
    tip = rotation.from_axis_angle(np.radians([-90.0, 0.0, 0.0]))
    quats = part.rotations.copy()
    quats[:, 0] = rotation.multiply(tip, quats[:, 0])
    return replace(part, rotations=quats)


def carry_part(motion: Motion, part: slice) -> Motion:
    contacts = None if motion.contacts is None else motion.contacts[part]
    return replace(
        motion, root=motion.root[part], rotations=motion.rotations[part], contacts=contacts, actions=None,
        interaction_start=None,
    )  # fmt: skip


@pytest.fixture
def source():
    """Return a human with the take, in an otherwise empty file."""
    take()
    rigs.reset()
    owner = character.create_character(bpy.context)
    keyframes.write_motion(owner, take(), "Sit")
    return owner


def target(kind: str, dressed: bool = True) -> bpy.types.Object:
    """Return a rig to retarget to; an unknown one has its bone table filled in."""
    if kind.startswith("rigify"):
        rig = humanoids.rigify(kind.split()[1])
    elif kind == "smplx":
        rig = rigs.make("meshcapade", name="Rig")
    else:
        rig = humanoids.make(kind)
    bpy.context.view_layer.objects.active = rig
    if kind == "strange":
        carry_to_rig.guess_map(bpy.context)
    if dressed:
        humanoids.dress(rig, shown_bones(rig))
    return rig


def shown_bones(rig: bpy.types.Object) -> dict[str, str]:
    """Return joint -> deform bone: of a generated Rigify rig not the controls."""
    known, bones = carry_to_rig.bones_of(rig)
    if known == "Rigify controls":
        deforming = next(names for names in maps.KNOWN if names.name == "Rigify bones")
        return deforming.found(bone.name for bone in rig.data.bones)
    return bones


@dataclass
class Shown:
    """The evaluated bones in all frames, network frame: heads (T, 3), and rotations from rest (T, 3, 3)."""

    heads: dict[str, np.ndarray]
    turned: dict[str, np.ndarray]

    def way(self, start: str, end: str) -> np.ndarray:
        way = self.heads[end] - self.heads[start]
        return way / np.linalg.norm(way, axis=-1, keepdims=True)


def played(rig: bpy.types.Object, action: bpy.types.Action) -> Shown:
    """Evaluate the rig frame by frame, with constraints and drivers."""
    scene, bones = bpy.context.scene, shown_bones(rig)
    poses = {joint: [] for joint in bones}
    for frame in range(int(action.frame_range[0]), int(action.frame_range[1]) + 1):
        scene.frame_set(frame)
        shown = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
        for joint, bone in bones.items():
            poses[joint].append(np.array(shown.matrix_world @ shown.pose.bones[bone].matrix))
    to_network = frames.NETWORK_FROM_BLENDER
    heads, turned = {}, {}
    for joint, matrices in poses.items():
        matrices = np.array(matrices)  # noqa: PLW2901
        rest = np.array(rig.data.bones[bones[joint]].matrix_local)[:3, :3]
        turns = to_network @ matrices[:, :3, :3]
        turned[joint] = turns / np.linalg.norm(turns, axis=-2, keepdims=True) @ rest.T
        heads[joint] = matrices[:, :3, 3] @ to_network.T
    return Shown(heads, turned)


def carried(rig: bpy.types.Object, source: bpy.types.Object) -> retargeting.Retargeted:
    """Return the take that the rig is expected to show."""
    bones = carry_to_rig.bones_of(rig)[1]
    motion = keyframes.read_motion(source, source.animation_data.action)
    return retargeting.retarget(
        motion, read_rig.read(bpy.context, rig), bones, character.body_of(source).vertices
    )


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Degrees between directions (..., 3)."""
    lengths = np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1)
    return np.degrees(np.arccos(np.clip(np.sum(a * b, axis=-1) / lengths, -1, 1)))


SHORT = 11  # frames; of shorter stances too few are left for a median without those at the ends
RIGS = ("smplx", "mixamo", "unreal 4", "unreal 5", "strange", "rigify basic", "rigify full", "rigify metarig")


@pytest.mark.parametrize("kind", RIGS)
def test_what_is_played(source, kind):
    """All checks in one test: evaluating the frames takes most of the time."""
    rig = target(kind)
    place(rig, kind)
    old = source.animation_data.action
    result = carry_to_rig.carry_to_rig(bpy.context)
    assert result.owner == rig and rig.animation_data.action == result.action != old
    assert tuple(result.action.frame_range) == tuple(old.frame_range)
    shown, wanted = played(rig, result.action), carried(rig, source)
    positions, _ = take().forward_kinematics()
    ours, _ = wanted.motion.forward_kinematics()
    own = lambda joint: positions[:, skeleton.INDEX[joint]]
    for joint in LEGS:
        assert np.abs(shown.heads[joint] - ours[:, skeleton.INDEX[joint]]).max() < 2e-3, joint
    feet_stand(wanted, result)
    faces_alike(shown, own)
    trunk_turns_alike(shown)
    limbs_point_alike(shown, own)
    knees_bend_alike(shown, own)
    nothing_flips(shown, wanted)
    hips_are_on_the_seat(shown, own, wanted, kind)


def place(rig: bpy.types.Object, kind: str) -> None:
    """Put the rig elsewhere, in various rotation modes and a random pose: none of this may matter."""
    rig.location = (3.0, -1.0, 0.7)
    rig.rotation_euler.rotate_axis("Y" if kind == "mixamo" else "Z", 2.0)
    if kind in ("unreal 4", "strange", "smplx"):
        rig.scale = rig.scale * 1.04
    for k, bone in enumerate(rig.pose.bones):
        if not bone.name.startswith(("MCH", "ORG", "DEF", "VIS", "tweak")) and not bone.constraints:
            bone.rotation_mode = ("QUATERNION", "XYZ", "AXIS_ANGLE", "ZXY", "YZX")[k % 5]
    for name in ("root", "hips", "pelvis", "torso"):
        if name in rig.pose.bones:
            rig.pose.bones[name].location = (0.3, 0.1, -0.2)
    bpy.context.view_layer.update()


def feet_stand(wanted: retargeting.Retargeted, result: carry_to_rig.Result) -> None:
    """While a foot is flat its sole is still, on the ground, and its middle where the take's is."""
    motion, prints = take(), Footprints.of(take())
    theirs, turned = motion.forward_kinematics()
    ours, ours_turned = wanted.motion.forward_kinematics()
    assert result.missed < 0.01
    speeds = []
    for plan in foot_plan.plan_feet(motion, prints):
        ankle = plan.foot.ankle
        soles = []
        for joints, places, quats in (
            (motion.rest_joints, theirs, turned),
            (wanted.motion.rest_joints, ours, ours_turned),
        ):
            middle = carrying.sole_middle(joints, plan.foot)
            soles.append(
                places[:, ankle] + rotation.rotate(quats[:, ankle], np.tile(middle, (len(places), 1)))
            )
        for stance in plan.stances:
            if stance.flat is None or stance.flat[1] - stance.flat[0] < SHORT:
                continue
            part = slice(stance.flat[0] + 2, stance.flat[1] - 2)
            speed = np.linalg.norm(np.diff(soles[1][part], axis=0), axis=-1) * motion.fps
            # A leg that is nearly straight when its heel lands is at the end of its reach for a few frames.
            assert np.median(speed) < 0.015, (plan.foot.side, stance)
            speeds += speed.tolist()
            ground = prints.support(soles[1][part])[0]
            # Feet of takes that are not refined may hover a little; here they stand.
            hovers = np.abs(soles[0][part, 1] - ground).max()
            moved = np.linalg.norm(soles[1][part].mean(0) - soles[0][part].mean(0))
            assert moved < 0.01 + hovers < 0.03, (plan.foot.side, stance)
            assert np.abs(soles[1][part, 1] - ground).max() < 0.01, (plan.foot.side, stance)
    assert len(speeds) > 150 and np.mean(speeds) < 0.01


def faces_alike(shown: Shown, own) -> None:
    """Hips across, and forward, as the take's."""
    assert angle(shown.way("right_hip", "left_hip"), own("left_hip") - own("right_hip")).max() < 1.0
    forward = np.cross(shown.way("right_hip", "left_hip"), [0, 1, 0])
    toes = shown.way("left_ankle", "left_foot")[-1] + shown.way("right_ankle", "right_foot")[-1]
    assert toes @ forward[-1] > 0


def trunk_turns_alike(shown: Shown) -> None:
    """Chest and head turn from frame to frame as the take's."""
    _, quats = take().forward_kinematics()
    for joint in ("spine3", "head"):
        theirs = rotation.quaternion_to_matrix(quats[:, skeleton.INDEX[joint]])
        both = [turned @ turned[0].T for turned in (shown.turned[joint], theirs)]
        trace = np.einsum("tab,tab->t", *both)
        assert np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))).max() < 2.0, joint


def limbs_point_alike(shown: Shown, own) -> None:
    """Arms as the take's, whatever the rest pose; hands turned alike."""
    for side in ("left", "right"):
        for start, end in (("shoulder", "elbow"), ("elbow", "wrist")):
            way = own(f"{side}_{end}") - own(f"{side}_{start}")
            assert angle(shown.way(f"{side}_{start}", f"{side}_{end}"), way).max() < 1.5, (side, start)
        if f"{side}_index1" not in shown.heads:
            continue
        palm = lambda at, side=side: np.cross(
            at(f"{side}_middle1") - at(f"{side}_wrist"), at(f"{side}_index1") - at(f"{side}_pinky1")
        )
        assert angle(palm(shown.heads.__getitem__), palm(own)).max() < 3.0
        curl = own(f"{side}_index3") - own(f"{side}_index2")
        assert angle(shown.way(f"{side}_index2", f"{side}_index3"), curl).max() < 3.0


def knees_bend_alike(shown: Shown, own) -> None:
    """A knee lies to the same side of its leg as the take's."""
    for side in ("left", "right"):
        out = [_out_of_line(*(at(f"{side}_{joint}") for joint in ("hip", "knee", "ankle"))) for at in (
            shown.heads.__getitem__, own
        )]  # fmt: skip
        bent = np.minimum(*(np.linalg.norm(one, axis=-1) for one in out)) > 0.06
        assert bent.mean() > 0.3
        assert angle(out[0][bent], out[1][bent]).max() < 30.0, side


def _out_of_line(hip: np.ndarray, knee: np.ndarray, ankle: np.ndarray) -> np.ndarray:
    line = (ankle - hip) / np.linalg.norm(ankle - hip, axis=-1, keepdims=True)
    way = knee - hip
    return way - np.sum(way * line, axis=-1, keepdims=True) * line


def nothing_flips(shown: Shown, wanted: retargeting.Retargeted) -> None:
    """No bone turns farther from frame to frame than the fastest joint of the take and a little."""
    _, quats = take().forward_kinematics()
    step = np.abs(np.sum(quats[1:] * quats[:-1], axis=-1))
    fastest = np.degrees(2 * np.arccos(np.clip(step, -1, 1))).max()
    for joint, turned in shown.turned.items():
        turn = np.einsum("tab,tcb->tac", turned[1:], turned[:-1])
        steps = np.degrees(np.arccos(np.clip((np.trace(turn, axis1=1, axis2=2) - 1) / 2, -1, 1)))
        assert steps.max() < fastest + 12.0, joint


def hips_are_on_the_seat(shown: Shown, own, wanted: retargeting.Retargeted, kind: str) -> None:
    """At the end the hips are over the take's, higher by what the body is thicker; standing, as the legs are long."""
    hips = lambda at: (at("left_hip") + at("right_hip")) / 2
    away = hips(shown.heads.__getitem__) - hips(own)
    assert np.abs(away[:, [0, 2]]).max() < 2e-3
    thick = landmarks.seat_depth(character.human.load().vertices, take().rest_joints)
    assert away[-1, 1] == pytest.approx(wanted.fit.seat - thick, abs=5e-3)
    tall, taller = (
        landmarks.hips(joints)[1] - carrying.sole_height(joints)
        for joints in (take().rest_joints, wanted.motion.rest_joints)
    )
    assert away[0, 1] == pytest.approx((taller / tall - 1) * hips(own)[0, 1], abs=0.03)


def test_an_smplx_armature_gets_the_same_take(source):
    """The upper body is the same; the legs differ, because feet are locked."""
    rig = target("smplx", dressed=False)
    carry_to_rig.carry_to_rig(bpy.context)
    again = keyframes.read_motion(rig)
    body = [
        skeleton.INDEX[joint] for joint in ("pelvis", "spine1", "spine3", "head", "left_elbow", "right_wrist")
    ]
    same = np.abs(np.sum(again.rotations[:, body] * take().rotations[:, body], axis=-1))
    assert same.min() > 1 - 1e-6
    assert np.abs(again.root - take().root)[:, [0, 2]].max() < 1e-4


def test_legs_that_are_too_short_are_reported(source):
    rig = target("mixamo")
    rig.scale = rig.scale * 0.35
    result = carry_to_rig.carry_to_rig(bpy.context)
    assert result.missed > 0.02 and "cm off its position" in carry_to_rig.sentence(result)


def test_bones_with_constraints_are_reported(source):
    rig = target("mixamo", dressed=False)
    assert not carry_to_rig.carry_to_rig(bpy.context).constrained
    rig.pose.bones["mixamorig:LeftHand"].constraints.new("COPY_ROTATION").target = source
    result = carry_to_rig.carry_to_rig(bpy.context)
    assert result.constrained == ("mixamorig:LeftHand",)
    assert "Constraints may override mixamorig:LeftHand" in carry_to_rig.sentence(result)


def test_lying_bodies_keep_the_legs_of_the_take(source):
    """Feet that do not stand follow their legs, whose knees do not change."""
    rig = target("mixamo")
    keyframes.write_motion(source, lying(), "Lie")
    carry_to_rig.carry_to_rig(bpy.context)
    wanted = carried(rig, source)
    assert not wanted.stands.any()
    knees = [skeleton.INDEX[f"{side}_knee"] for side in ("left", "right")]
    now = wanted.motion.rotations[:, knees]
    then = keyframes.read_motion(source).rotations[:, knees]
    assert (
        np.abs(np.sum(now * then, axis=-1)).min() > 1 - 2e-3
    )  # 7 degrees; feet that stood would bend them by far more


def test_without_contacts_low_and_still_hips_count_as_resting():
    unlabelled = replace(take(), contacts=None)
    over = landmarks.hips(take().forward_kinematics()[0])[:, 1] / 0.85
    with_contacts = take().contacts[:, CONTACTS.index("pelvis")] > 0.5
    without = carrying._resting(unlabelled, over)
    assert without[-20:].all() and with_contacts[-20:].all() and not without[:60].any()


def kept(obj: bpy.types.Object) -> list:
    """All that an armature and its Action are, to be compared."""
    bones = [
        (
            bone.name,
            bone.parent and bone.parent.name,
            tuple(bone.head_local),
            tuple(map(tuple, bone.matrix_local)),
        )
        for bone in obj.data.bones
    ]
    pose = [
        (
            bone.name,
            bone.rotation_mode,
            [(c.name, c.type, c.mute) for c in bone.constraints],
            {key: str(value) for key, value in bone.items() if isinstance(value, (int, float, str))},
        )
        for bone in obj.pose.bones
    ]
    data = obj.animation_data
    action = data and data.action
    curves = []
    for curve in compat.curves(action, obj) if action else ():
        points = np.empty(len(curve.keyframe_points) * 2)
        curve.keyframe_points.foreach_get("co", points)
        curves.append((curve.data_path, curve.array_index, points.tobytes()))
    return [bones, pose, tuple(map(tuple, obj.matrix_basis)), action and action.name, curves]


@pytest.mark.parametrize("kind", ["unreal 4", "rigify basic"])
def test_nothing_else_changes(source, kind):
    rig = target(kind)
    own = bpy.data.actions.new("Mine")
    compat.CurveWriter(own, rig).add("location", 0, np.array([1.0, 9.0]), np.array([0.0, 0.5]), "Object")
    compat.assign(rig, own)
    bpy.context.scene.frame_set(1)
    before, sets = (kept(source), kept(rig)), set(bpy.data.actions)
    data = {kind: len(getattr(bpy.data, kind)) for kind in ("objects", "meshes", "armatures", "texts")}
    result = carry_to_rig.carry_to_rig(bpy.context)
    assert set(bpy.data.actions) - sets == {result.action}
    assert kept(source) == before[0]
    compat.assign(rig, own)
    assert kept(rig) == before[1]
    assert own.use_fake_user and result.action.use_fake_user
    assert data == {kind: len(getattr(bpy.data, kind)) for kind in data}
    assert result.action["samp_carried"]["action"] == "Sit"


def test_rigify_is_switched_to_fk_in_the_action_only(source):
    rig = target("rigify basic")
    result = carry_to_rig.carry_to_rig(bpy.context)
    paths = {curve.data_path for curve in compat.curves(result.action, rig)}
    for bone in ("thigh_parent.L", "thigh_parent.R", "upper_arm_parent.L", "upper_arm_parent.R"):
        assert f'pose.bones["{bone}"]["IK_FK"]' in paths
    assert 'pose.bones["torso"]["neck_follow"]' in paths
    assert result.switched == 10 and "switches its limbs to FK" in carry_to_rig.sentence(result)
    bpy.context.scene.frame_set(5)
    assert rig.pose.bones["thigh_parent.L"]["IK_FK"] == 1.0


def test_a_carried_rig_is_no_obstacle(source):
    """Neither it nor its meshes, also under another name, or with the take on an NLA track."""
    other = target("mixamo")
    names = lambda: {obj.name for obj in characters.people(bpy.context)}
    assert names() == {source.name}
    carry_to_rig.carry_to_rig(bpy.context, other.name, source.name)
    assert names() == {source.name, other.name}
    other.name = "Renamed"
    assert names() == {source.name, "Renamed"}
    dressed = {obj.name for obj in read_scene.with_dependants(bpy.context, [other]) if obj.type == "MESH"}
    everything = read_scene.read_scene(bpy.context)
    shown = read_scene.read_scene(bpy.context, characters.people(bpy.context))
    assert dressed & set(everything.names) and not dressed & set(shown.names)


def test_operator_and_function_give_the_same(source):
    rig = target("mixamo")
    first = carry_to_rig.carry_to_rig(bpy.context, "Rig", "Human", "Sit", 20, 60).action
    options = {"target": "Rig", "character": "Human", "action_name": "Sit"}
    outcome = bpy.ops.samp.carry_to_rig(**options, use_range=True, frame_start=20, frame_end=60)
    second = rig.animation_data.action
    assert outcome == {"FINISHED"} and second != first
    assert tuple(first.frame_range) == tuple(second.frame_range) == (20, 60)
    keys = []
    for action in (first, second):
        compat.assign(rig, action)
        keys.append(kept(rig)[-1])
    assert keys[0] == keys[1] and len(keys[0]) > 100


def test_undo_takes_one_step(source):
    target("mixamo", dressed=False)
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    names = {action.name for action in bpy.data.actions}
    assert bpy.ops.samp.carry_to_rig("EXEC_DEFAULT", True) == {"FINISHED"}
    assert bpy.data.objects["Rig"].animation_data.action.name == "Sit on Rig"
    bpy.ops.ed.undo()
    data = bpy.data.objects["Rig"].animation_data
    assert data is None or data.action is None
    assert {action.name for action in bpy.data.actions} == names


def test_the_table_is_filled_in_kept_and_saved(tmp_path):
    rigs.reset()
    rig = humanoids.make("strange")
    bone_table.fill(rig, {"head": "Bip Neck"})
    assert bpy.ops.samp.guess_rig_map(target="Rig") == {"FINISHED"}
    table = bone_table.read(rig)
    wanted = humanoids.FAMILIES["strange"].names | {"head": "Bip Neck"}
    assert table == {joint: bone for joint, bone in wanted.items() if joint != "neck"}
    assert [row.joint for row in rig.samp_rig_map] == list(maps.JOINTS)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    rigs.reset()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    assert bone_table.read(bpy.data.objects["Rig"]) == table
    assert bpy.ops.samp.guess_rig_map(target="Rig", keep=False) == {"FINISHED"}
    assert bone_table.read(bpy.data.objects["Rig"]) == humanoids.FAMILIES["strange"].names


def test_the_table_is_what_counts(source):
    rig = target("mixamo", dressed=False)
    carry_to_rig.guess_map(bpy.context)
    row = rig.samp_rig_map["head"]
    row.bone = ""
    result = carry_to_rig.carry_to_rig(bpy.context)
    assert (result.known, result.body_joints) == ("bone table", 21)
    paths = {curve.data_path for curve in compat.curves(result.action, rig)}
    assert not any("mixamorig:Head" in path for path in paths)


def _exchanged() -> None:
    rig = bpy.data.objects["Rig"]
    bones = carry_to_rig.bones_of(rig)[1]
    other = {"left": "right", "right": "left"}
    swap = lambda joint: "_".join(
        [other.get(joint.split("_")[0], joint.split("_")[0]), *joint.split("_")[1:]]
    )
    bone_table.fill(rig, {swap(joint): bone for joint, bone in bones.items()})


def _broken_row() -> None:
    carry_to_rig.guess_map(bpy.context, "Rig")
    bpy.data.objects["Rig"].samp_rig_map["left_knee"].bone = "Nothing"


def _unscaled() -> None:
    bpy.data.objects["Rig"].scale = (0.01, 0.02, 0.01)


def _no_take() -> None:
    bpy.data.objects["Human"].animation_data.action = None


def _renamed() -> None:
    bpy.data.objects["Rig"].data.bones["mixamorig:Hips"].name = "Something"


def _nothing_active() -> None:
    bpy.context.view_layer.objects.active = None


def _two_sources() -> None:
    character.create_character(bpy.context, name="Second")
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    bpy.context.view_layer.objects.active = bpy.data.objects["Rig"]


@pytest.mark.parametrize(
    ("change", "options", "reason"),
    [
        (_exchanged, {}, "left and right are exchanged"),
        (_broken_row, {}, "has no bone 'Nothing' for left_knee"),
        (_unscaled, {}, "apply its scale"),
        (_no_take, {}, "has no Action; generate or choose"),
        (_renamed, {}, "press Guess Bones"),
        (_nothing_active, {}, "No armature is active"),
        (_two_sources, {}, "several characters"),
        (None, {"target": "Nobody"}, "no object 'Nobody'"),
        (None, {"target": "Human"}, "no other SMPL-X armature"),
        (None, {"character": "Rig"}, "is not an SMPL-X armature"),
        (None, {"action_name": "Dance"}, "no Action 'Dance'"),
        (None, {"use_range": True, "frame_start": 9, "frame_end": 3}, "end after the start"),
    ],
)
def test_what_goes_wrong_is_one_sentence(source, change, options, reason):
    target("mixamo", dressed=False)
    if change:
        change()
    before = set(bpy.data.actions)
    with pytest.raises(RuntimeError, match=reason) as caught:
        bpy.ops.samp.carry_to_rig(**options)
    assert "Traceback" not in str(caught.value)
    assert set(bpy.data.actions) == before


def test_footprints_of_a_foot_that_never_stands_are_its_lowest_place():
    motion = carry_part(take(), slice(0, 1))
    assert Footprints.of(motion).support(np.zeros((3, 3)))[0] == pytest.approx(
        Footprints.of(take()).places[0, 1], abs=0.02
    )
