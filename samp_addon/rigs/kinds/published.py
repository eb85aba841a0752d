"""Rigs of character makers, motion capture and game tools, by their bone names."""

from __future__ import annotations

from .name_map import rig_of

_ARP = "{0}root.x {0}spine_01.x {0}spine_02.x {0}spine_03.x {0}neck.x {0}head.x"
PUBLISHED = (
    rig_of(
        "VRM",
        "Hips Spine Chest UpperChest Neck Head",
        "{s}_UpperLeg {s}_LowerLeg {s}_Foot {s}_ToeBase {s}_Shoulder {s}_UpperArm {s}_LowerArm {s}_Hand",
        ("L", "R"),
        "{s}_{f}{k}",
        "Index Middle Little Ring Thumb",
        prefix="J_Bip_C_|J_Bip_",
    ),
    rig_of(
        "MMD",
        "腰|センター 上半身 - 上半身2 首 頭",
        "{s}足 {s}ひざ {s}足首 {s}足先EX|{s}つま先 {s}肩 {s}腕 {s}ひじ {s}手首",
        ("左", "右"),
    ),
    rig_of(
        "MMD in Blender",
        "腰|センター 上半身 - 上半身2 首 頭",
        "足.{s} ひざ.{s} 足首.{s} 足先EX.{s}|つま先.{s} 肩.{s} 腕.{s} ひじ.{s} 手首.{s}",
        ("L", "R"),
    ),
    rig_of(
        "Auto-Rig Pro",
        _ARP.format(""),
        "thigh_stretch.{s} leg_stretch.{s} foot.{s} toes_01.{s} shoulder.{s} arm_stretch.{s} forearm_stretch.{s} "
        "hand.{s}",
        ("l", "r"),
        "{f}{k}.{s}",
    ),
    rig_of(
        "Auto-Rig Pro controls",
        _ARP.format("c_"),
        "c_thigh_fk.{s} c_leg_fk.{s} c_foot_fk.{s} c_toes_fk.{s} c_shoulder.{s} c_arm_fk.{s} c_forearm_fk.{s} "
        "c_hand_fk.{s}",
        ("l", "r"),
        "c_{f}{k}.{s}",
    ),
    rig_of(
        "SMPL",
        "Pelvis Spine1 Spine2 Spine3 Neck Head",
        "{s}_Hip {s}_Knee {s}_Ankle {s}_Foot {s}_Collar {s}_Shoulder {s}_Elbow {s}_Wrist",
        ("L", "R"),
        prefix="[fmn]_avg_",
    ),
    rig_of(
        "SOMA",
        "Hips Spine1 Spine2 Chest Neck1 Head",
        "{s}Leg {s}Shin {s}Foot {s}ToeBase {s}Shoulder {s}Arm {s}ForeArm {s}Hand",
        ("Left", "Right"),
        "{s}Hand{f}{k}",
        "Index Middle Pinky Ring Thumb",
    ),
    rig_of(
        "CMU BVH",
        "Hips LowerBack Spine Spine1 Neck1 Head",
        "{s}UpLeg {s}Leg {s}Foot {s}ToeBase {s}Shoulder {s}Arm {s}ForeArm {s}Hand",
        ("Left", "Right"),
    ),
    rig_of(
        "Xsens",
        "Pelvis L5|Spine T12|Spine1 T8|Spine2 Neck Head",
        "{s}UpperLeg {s}LowerLeg {s}Foot {s}Toe {s}Shoulder {s}UpperArm {s}ForeArm|{s}Forearm {s}Hand",
        ("Left", "Right"),
    ),
    rig_of(
        "Reallusion",
        "CC_Base_Hip|CC_Base_Pelvis CC_Base_Waist CC_Base_Spine01 CC_Base_Spine02 CC_Base_NeckTwist01 CC_Base_Head",
        "CC_Base_{s}_Thigh CC_Base_{s}_Calf CC_Base_{s}_Foot CC_Base_{s}_ToeBase CC_Base_{s}_Clavicle "
        "CC_Base_{s}_Upperarm CC_Base_{s}_Forearm CC_Base_{s}_Hand",
        ("L", "R"),
        "CC_Base_{s}_{f}{k}",
        "Index Mid Pinky Ring Thumb",
    ),
    rig_of(
        "MakeHuman",
        "root spine05 spine03 spine01 neck01 head",
        "upperleg01.{s} lowerleg01.{s} foot.{s} toe1-1.{s} clavicle.{s} upperarm01.{s} lowerarm01.{s} wrist.{s}",
        ("L", "R"),
    ),
    rig_of(
        "DAZ Genesis 8",
        "hip abdomenLower abdomenUpper|chestLower chestUpper neckLower head",
        "{s}ThighBend {s}Shin {s}Foot {s}Toe {s}Collar {s}ShldrBend {s}ForearmBend {s}Hand",
        ("l", "r"),
        "{s}{f}{k}",
        "Index Mid Pinky Ring Thumb",
    ),
    rig_of(
        "DAZ Genesis 9",
        "hip spine1 spine2|spine3 spine4 neck1 head",
        "{s}_thigh {s}_shin {s}_foot {s}_toes {s}_shoulder {s}_upperarm {s}_forearm {s}_hand",
        ("l", "r"),
        "{s}_{f}{k}",
        "index mid pinky ring thumb",
    ),
)
