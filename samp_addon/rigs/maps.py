"""Bone names of known rigs, and recognition of a rig by its bone names."""

from __future__ import annotations

from collections.abc import Iterable

from .. import skeleton
from .kinds.name_map import FINGERS, HANDS, JOINTS, NameMap, middle_of, sides_of
from .kinds.published import PUBLISHED

__all__ = ["FINGERS", "HANDS", "JOINTS"]

ESSENTIAL = ("pelvis",) + tuple(
    f"{side}_{joint}" for joint in ("hip", "knee", "ankle", "shoulder", "elbow") for side in ("left", "right")
)
"""Joints that must have a bone; the others may be missing."""

MIN_MATCH = 0.7
"""Share of the body bones of a known rig that an armature must have to be recognised as one."""


def recognise(names: Iterable[str]) -> tuple[NameMap, dict[str, str]] | None:
    """Return the known rig that fits these bone names best and its joint -> bone name, or None where none fits."""
    names, best = list(names), None
    for rig in KNOWN:
        bones = rig.found(names)
        known = [joint for joint in skeleton.BODY_JOINTS if joint in rig.bones]
        body = sum(joint in bones for joint in known) / len(known)
        if body < MIN_MATCH or any(joint not in bones for joint in ESSENTIAL):
            continue
        if best is None or body > best[0]:
            best = body, rig, bones
    return None if best is None else best[1:]


_SMPLX = NameMap("SMPL-X", {joint: (joint,) for joint in JOINTS})
_MIXAMO = NameMap(
    "Mixamo",
    middle_of(pelvis="Hips", spine1="Spine", spine2="Spine1", spine3="Spine2", neck="Neck", head="Head")
    | sides_of(
        {
            "hip": "{s}UpLeg",
            "knee": "{s}Leg",
            "ankle": "{s}Foot",
            "foot": "{s}ToeBase",
            "collar": "{s}Shoulder",
            "shoulder": "{s}Arm",
            "elbow": "{s}ForeArm",
            "wrist": "{s}Hand",
        },
        "{s}Hand{f}{k}",
        {finger: finger.capitalize() for finger in FINGERS},
        ("Left", "Right"),
    ),
    prefix=r"mixamorig\d*[:_]?",
)
_UNREAL_SIDES = sides_of(
    {
        "hip": "thigh_{s}",
        "knee": "calf_{s}",
        "ankle": "foot_{s}",
        "foot": "ball_{s}",
        "collar": "clavicle_{s}",
        "shoulder": "upperarm_{s}",
        "elbow": "lowerarm_{s}",
        "wrist": "hand_{s}",
    },
    "{f}_{k0}_{s}",
    {},
    ("l", "r"),
)
_UNREAL_5 = NameMap(
    "Unreal 5 mannequin",
    middle_of(
        pelvis="pelvis", spine1="spine_01", spine2="spine_03", spine3="spine_05", neck="neck_01", head="head"
    )
    | _UNREAL_SIDES,
)
_UNREAL_4 = NameMap(
    "Unreal 4 mannequin",
    middle_of(
        pelvis="pelvis", spine1="spine_01", spine2="spine_02", spine3="spine_03", neck="neck_01", head="head"
    )
    | _UNREAL_SIDES,
)
_RIGIFY_FINGERS = {finger: f"f_{finger}" for finger in FINGERS if finger != "thumb"}
# The torso control moves pelvis and lower back as one; the upper spine bends relative to it.
_RIGIFY_CONTROLS = NameMap(
    "Rigify controls",
    middle_of(pelvis="torso", spine1="spine_fk.002", spine3="spine_fk.003", neck="neck", head="head")
    | sides_of(
        {
            "hip": "thigh_fk.{s}",
            "knee": "shin_fk.{s}",
            "ankle": "foot_fk.{s}",
            "foot": "toe_fk.{s} toe.{s}",
            "collar": "shoulder.{s}",
            "shoulder": "upper_arm_fk.{s}",
            "elbow": "forearm_fk.{s}",
            "wrist": "hand_fk.{s}",
        },
        "{f}.{k0}.{s}",
        _RIGIFY_FINGERS,
        ("L", "R"),
    ),
)
# A metarig, or the deform bones alone, as exported to game engines.
_RIGIFY_BONES = NameMap(
    "Rigify bones",
    middle_of(
        pelvis="spine", spine1="spine.001", spine2="spine.002", spine3="spine.003", neck="spine.004", head="spine.006"
    )
    | sides_of(
        {
            "hip": "thigh.{s}",
            "knee": "shin.{s}",
            "ankle": "foot.{s}",
            "foot": "toe.{s}",
            "collar": "shoulder.{s}",
            "shoulder": "upper_arm.{s}",
            "elbow": "forearm.{s}",
            "wrist": "hand.{s}",
        },
        "{f}.{k0}.{s}",
        _RIGIFY_FINGERS,
        ("L", "R"),
    ),
    prefix="DEF-",
)  # fmt: skip

KNOWN = (_SMPLX, _MIXAMO, _UNREAL_5, _UNREAL_4, _RIGIFY_CONTROLS, _RIGIFY_BONES, *PUBLISHED)
"""All known rigs; of two that fit equally well the first one is taken."""

FOLLOWS = {"IK_FK": 1.0, "FK_limb_follow": 0.0, "neck_follow": 1.0, "head_follow": 1.0}
"""Custom properties of the bones of a generated Rigify rig, and the values with which its FK controls inherit rotations
as their bones do: limbs by FK, each turning with its parent."""

FOLLOWS_FOR = _RIGIFY_CONTROLS.bones["left_hip"] + _RIGIFY_CONTROLS.bones["left_shoulder"]
"""A rig in which one of these bones is keyed is a generated Rigify rig."""
