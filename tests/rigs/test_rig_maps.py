"""Recognition of rigs by bone names, guesses at bones, and spines of any length."""

from __future__ import annotations

import re

import numpy as np
import pytest
from samp_blender.samp_addon import skeleton
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.refine.proportions import carrying
from samp_blender.samp_addon.refine.proportions import hips as landmarks
from samp_blender.samp_addon.rigs import fitting, guessing, maps, spines
from samp_blender.samp_addon.rigs.rig import Rig


def names_of(known: str, prefix: str = "") -> list[str]:
    """All bones that a known rig has."""
    rig = next(rig for rig in maps.KNOWN if rig.name == known)
    return [prefix + names[0] for names in rig.bones.values()]


@pytest.mark.parametrize(
    ("known", "prefix"),
    [(rig.name, "") for rig in maps.KNOWN]
    + [("Mixamo", prefix) for prefix in ("mixamorig:", "mixamorig7:", "mixamorig12:", "mixamorig_")]
    + [("Rigify bones", "DEF-")],
)
def test_known_rigs_are_recognised_among_other_bones(known, prefix):
    names = ["Camera", *names_of(known, prefix), "Sword", "skirt_01_l"]
    rig, bones = maps.recognise(names)
    assert rig.name == known
    assert set(bones.values()) == set(names) - {"Camera", "Sword", "skirt_01_l"}
    assert all(bones[joint].startswith(prefix) for joint in bones)


def test_a_generated_rig_is_moved_by_its_controls_not_by_its_deforming_bones():
    names = names_of("Rigify bones", "DEF-") + names_of("Rigify controls")
    assert maps.recognise(names)[0].name == "Rigify controls"


@pytest.mark.parametrize("left_out", ["LeftArm", "RightUpLeg", "Hips"])
def test_a_rig_without_what_is_essential_is_not_known(left_out):
    assert maps.recognise([name for name in names_of("Mixamo") if name != left_out]) is None


def test_a_rig_may_lack_fingers_toes_and_collars():
    lacking = ("Hand", "Toe", "LeftShoulder", "RightShoulder")
    names = [name for name in names_of("Mixamo") if not any(part in name for part in lacking)]
    found = maps.recognise(names)
    assert found[0].name == "Mixamo" and "left_wrist" not in found[1]
    assert maps.recognise(["Bone", "Bone.001"]) is None


UNKNOWN = {
    "capitals and words": (
        "Root / Hip: Root / Abdomen: Hip / Chest: Abdomen / Neck: Chest / Head: Neck / LeftThigh: Hip /"
        " LeftShin: LeftThigh / LeftFoot: LeftShin / LeftToe: LeftFoot / LeftCollar: Chest /"
        " LeftUpperArm: LeftCollar / LeftForearm: LeftUpperArm / LeftHand: LeftForearm / LeftThumb1: LeftHand /"
        " LeftThumb2: LeftThumb1 / LeftThumb3: LeftThumb2 / LeftUpperArmTwist: LeftUpperArm",
        "pelvis Hip, spine1 Abdomen, spine3 Chest, neck Neck, head Head, left_hip LeftThigh, left_knee LeftShin,"
        " left_ankle LeftFoot, left_foot LeftToe, left_collar LeftCollar, left_shoulder LeftUpperArm,"
        " left_elbow LeftForearm, left_wrist LeftHand, left_thumb1 LeftThumb1, left_thumb2 LeftThumb2,"
        " left_thumb3 LeftThumb3",
    ),
    "suffixes": (
        "hips / spine: hips / chest: spine / upper_chest: chest / neck: upper_chest / head: neck / upper_leg.L: hips /"
        " lower_leg.L: upper_leg.L / foot.L: lower_leg.L / toes.L: foot.L / shoulder.L: upper_chest /"
        " upper_arm.L: shoulder.L / lower_arm.L: upper_arm.L / hand.L: lower_arm.L / eye.L: head / foot_ik.L:",
        "pelvis hips, spine1 spine, spine2 chest, spine3 upper_chest, neck neck, head head, left_hip upper_leg.L,"
        " left_knee lower_leg.L, left_ankle foot.L, left_foot toes.L, left_collar shoulder.L,"
        " left_shoulder upper_arm.L, left_elbow lower_arm.L, left_wrist hand.L",
    ),
    "a pelvis beside the spine": (
        "hip / pelvis: hip / abdomenLower: hip / chestUpper: abdomenLower / neckLower: chestUpper / head: neckLower /"
        " lThighBend: pelvis / lThighTwist: lThighBend / lShin: lThighTwist / lFoot: lShin / lToe: lFoot /"
        " lCollar: chestUpper / lShldrBend: lCollar / lShldrTwist: lShldrBend / lForearmBend: lShldrTwist /"
        " lForearmTwist: lForearmBend / lHand: lForearmTwist",
        "pelvis hip, spine1 abdomenLower, spine3 chestUpper, neck neckLower, head head, left_hip lThighBend,"
        " left_knee lShin, left_ankle lFoot, left_foot lToe, left_collar lCollar, left_shoulder lShldrBend,"
        " left_elbow lForearmBend, left_wrist lHand",
    ),
    "a prefix of words": (
        "CC_Base_Hip / CC_Base_Pelvis: CC_Base_Hip / CC_Base_Waist: CC_Base_Hip / CC_Base_Spine01: CC_Base_Waist /"
        " CC_Base_Spine02: CC_Base_Spine01 / CC_Base_NeckTwist01: CC_Base_Spine02 /"
        " CC_Base_NeckTwist02: CC_Base_NeckTwist01 / CC_Base_Head: CC_Base_NeckTwist02 /"
        " CC_Base_L_Thigh: CC_Base_Pelvis / CC_Base_L_ThighTwist01: CC_Base_L_Thigh /"
        " CC_Base_L_Calf: CC_Base_L_Thigh / CC_Base_L_Foot: CC_Base_L_Calf / CC_Base_L_ToeBase: CC_Base_L_Foot /"
        " CC_Base_L_Clavicle: CC_Base_Spine02 / CC_Base_L_Upperarm: CC_Base_L_Clavicle /"
        " CC_Base_L_Forearm: CC_Base_L_Upperarm / CC_Base_L_Hand: CC_Base_L_Forearm",
        "pelvis CC_Base_Hip, spine1 CC_Base_Waist, spine2 CC_Base_Spine01, spine3 CC_Base_Spine02,"
        " neck CC_Base_NeckTwist01, head CC_Base_Head, left_hip CC_Base_L_Thigh, left_knee CC_Base_L_Calf,"
        " left_ankle CC_Base_L_Foot, left_foot CC_Base_L_ToeBase, left_collar CC_Base_L_Clavicle,"
        " left_shoulder CC_Base_L_Upperarm, left_elbow CC_Base_L_Forearm, left_wrist CC_Base_L_Hand",
    ),
    "a limb's middle is called otherwise": (
        "pelvis / spine: pelvis / neck: spine / head: neck / l_thigh: pelvis / l_mystery: l_thigh /"
        " l_foot: l_mystery / l_shoulder: spine / l_elbow: l_shoulder / l_hand: l_elbow",
        "pelvis pelvis, spine3 spine, neck neck, head head, left_hip l_thigh, left_knee l_mystery,"
        " left_ankle l_foot, left_shoulder l_shoulder, left_elbow l_elbow, left_wrist l_hand",
    ),
}  # fmt: skip


def mirrored(name: str) -> str:
    """The bone of the other side."""
    for mark, other in ((r"^Left", "Right"), (r"^l(?=[_A-Z])", "r"), (r"\.L$", ".R"), ("_L_", "_R_")):
        name = re.sub(mark, other, name)
    return name


@pytest.mark.parametrize("kind", UNKNOWN)
def test_unknown_humanoids_are_guessed(kind):
    tree, wanted = UNKNOWN[kind]
    pairs = [part.strip().split(":") for part in tree.split("/")]
    names, above = [pair[0].strip() for pair in pairs], [(pair + [""])[1].strip() for pair in pairs]
    for name, parent in list(zip(names, above, strict=True)):
        if mirrored(name) != name and mirrored(name) not in names:
            names.append(mirrored(name))
            above.append(mirrored(parent))
    parents = [names.index(parent) if parent else -1 for parent in above]
    found = dict(pair.split() for pair in wanted.split(","))
    found |= {
        joint.replace("left", "right"): mirrored(bone)
        for joint, bone in found.items()
        if joint.startswith("left")
    }
    assert guessing.guess(names, parents, np.zeros((len(names), 3))) == found


def spine(count: int, constrained: tuple[int, ...] = ()) -> Rig:
    """A pelvis, a spine of some bones, a neck and a head, one over the other."""
    total = count + 3
    heads = np.array([[0.0, 0.0, k] for k in range(total)])
    return Rig(
        name="Spine",
        names=tuple(f"bone {k}" for k in range(total)),
        parents=np.arange(-1, total - 1),
        heads=heads,
        tails=heads + [0, 0, 1],
        bases=np.tile(np.eye(3), (total, 1, 1)),
        constrained=np.isin(np.arange(total), constrained),
        inherits=np.ones(total, bool),
        world=np.eye(4),
        turn=np.eye(3),
        scale=1.0,
    )


@pytest.mark.parametrize(
    ("count", "wanted"),
    [
        (1, [("spine2", "spine3", 1.0)]),
        (2, [("spine1", "spine2", 0.5), ("spine2", "spine3", 1.0)]),
        (3, [("pelvis", "spine1", 1.0), ("spine1", "spine2", 1.0), ("spine2", "spine3", 1.0)]),
        (
            5,
            [
                ("pelvis", "spine1", 0.6),
                ("spine1", "spine2", 0.2),
                ("spine1", "spine2", 0.8),
                ("spine2", "spine3", 0.4),
                ("spine2", "spine3", 1.0),
            ],
        ),
    ],
)
def test_a_spine_of_any_length_bends_as_a_whole(count, wanted):
    at = {"pelvis": 0, "spine1": 1, "neck": count + 1, "head": count + 2}
    links, neck = spines.spine_and_neck(spine(count), at)
    found = [(link.below, link.above, round(link.share, 6)) for link in links]
    along = lambda link: spines.SPINE.index(link[1]) + link[2]
    assert [along(link) for link in found] == pytest.approx([along(link) for link in wanted])
    assert [link.bone for link in links] == list(range(1, count + 1))
    assert [(link.bone, link.above, link.share) for link in neck] == [(count + 1, "neck", 1.0)]


def test_machinery_between_the_bones_is_left_alone():
    at = {"pelvis": 0, "spine1": 2, "neck": 5, "head": 6}
    assert [link.bone for link in spines.spine_and_neck(spine(4, (1, 3)), at)[0]] == [2, 4]


def test_hips_are_as_high_as_the_legs_are_long_and_as_the_body_is_thick():
    over = np.array([1.0, 0.8, 0.6, 0.5, 0.5, 0.75, 1.0])
    resting = np.array([0, 0, 0, 1, 1, 0, 0], bool)
    raised = carrying.hip_lift(over, resting, 0.1 * over, 0.02, 1.0)
    np.testing.assert_allclose(
        raised, [0.1, 0.02 + 0.6 * 0.06, 0.02 + 0.2 * 0.04, 0.02, 0.02, 0.02 + 0.5 * 0.055, 0.1]
    )
    np.testing.assert_array_equal(carrying.hip_lift(over, resting & False, 0.1 * over, 0.02, 1.0), 0.1 * over)


def test_a_seat_is_as_far_behind_the_hips_as_the_skin():
    joints = skeleton.default_rest_joints()
    middle = landmarks.hips(joints)
    back = np.random.default_rng(0).uniform([-0.1, -0.15, -0.12], [0.1, 0.0, -0.12], (200, 3)) + middle
    assert landmarks.seat_depth(back, joints) == pytest.approx(0.12)
    assert landmarks.seat_depth(np.zeros((0, 3)), joints) is None


def test_a_map_that_cannot_be_is_refused():
    rig = spine(2)
    for bones, reason in (
        ({}, "'Spine' has no bone for pelvis"),
        (dict.fromkeys(maps.ESSENTIAL, "bone 0"), "is assigned to both"),
        ({joint: f"nothing {joint}" for joint in maps.ESSENTIAL}, "has no bone 'nothing pelvis'"),
    ):
        with pytest.raises(SampError, match=reason):
            fitting.fit(rig, bones, skeleton.default_rest_joints())


def _skeleton(bone_of):
    """Return names, parents and heads (B, 3) of the default body, in Blender's axes, with a bone for each joint."""
    rest = skeleton.default_rest_joints()
    joints = list(skeleton.BODY_JOINTS)
    parents = [int(skeleton.PARENTS[skeleton.INDEX[joint]]) for joint in joints]
    heads = np.array([rest[skeleton.INDEX[joint]] for joint in joints])
    return [bone_of(joint) for joint in joints], parents, heads[:, [0, 2, 1]] * [1, -1, 1]


@pytest.mark.parametrize("turn", [0, 90, 180, 270])
def test_nameless_bones_are_told_apart_by_hierarchy_and_place(turn):
    names, parents, heads = _skeleton(lambda joint: f"b{skeleton.INDEX[joint]}")
    cos, sin = np.round([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    turned = heads @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    found = guessing.guess(names, parents, turned)
    assert found == {joint: f"b{skeleton.INDEX[joint]}" for joint in skeleton.BODY_JOINTS}


@pytest.mark.parametrize(
    ("kind", "trunk", "thigh"),
    [
        ("MMD", ("腰", "上半身", "上半身2"), "{s}足 {s}ひざ {s}足首 {s}足先EX {s}肩 {s}腕 {s}ひじ {s}手首"),
        ("Reallusion", ("CC_Base_Hip",), ""),
        ("DAZ Genesis 9", ("hip", "spine1"), ""),
    ],
)
def test_published_rigs_are_recognised(kind, trunk, thigh):
    rig = next(rig for rig in maps.KNOWN if rig.name == kind)
    names = [options[0] for options in rig.bones.values()]
    found = maps.recognise(names)
    assert found is not None and found[0].name == kind
    assert set(trunk) <= set(found[1].values())
    assert not thigh or set(thigh.format(s="左").split()) <= set(found[1].values())
