"""How a known rig names the bones of the joints."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from ... import skeleton

FINGERS = ("index", "middle", "pinky", "ring", "thumb")
HANDS = tuple(f"{side}_{finger}{k}" for side in ("left", "right") for finger in FINGERS for k in (1, 2, 3))
JOINTS = skeleton.BODY_JOINTS + HANDS
"""The joints that are retargeted, in the order of a bone table: the body, then the fingers."""


@dataclass(frozen=True)
class NameMap:
    """A known rig. bones: joint -> possible names of its bone, the likeliest first. prefix: pattern of a prefix of all
    names."""

    name: str
    bones: Mapping[str, tuple[str, ...]]
    prefix: str = ""

    def found(self, names: Iterable[str]) -> dict[str, str]:
        """Return joint -> bone name for an armature with bones of these names."""
        present: dict[str, str] = {}
        for name in names:
            stem = re.sub(f"^(?:{self.prefix})", "", name) if self.prefix else name
            present.setdefault(stem, name)
        chosen = {}
        for joint, options in self.bones.items():
            bone = next((present[option] for option in options if option in present), None)
            if bone is not None:
                chosen[joint] = bone
        return chosen


def sides_of(body: Mapping[str, str], fingers: str, named: Mapping[str, str], sides: tuple[str, str]) -> dict:
    """Return joint -> possible bone names of both sides.

    In the names {s} is the side; in fingers {f} is the finger, {k} its joint and {k0} the joint with two digits. named:
    finger -> the rig's name for it, where it is not that of SMPL-X.
    """
    result = {}
    for side, mark in zip(("left", "right"), sides, strict=True):
        for joint, names in body.items():
            result[f"{side}_{joint}"] = tuple(name.format(s=mark) for name in names.split())
        for finger in FINGERS:
            for k in (1, 2, 3):
                name = fingers.format(s=mark, f=named.get(finger, finger), k=k, k0=f"{k:02d}")
                result[f"{side}_{finger}{k}"] = (name,)
    return result


def middle_of(**bones: str) -> dict[str, tuple[str, ...]]:
    """Return joint -> possible bone names of the trunk."""
    return {joint: tuple(names.split()) for joint, names in bones.items()}


_LIMBS = ("hip", "knee", "ankle", "foot", "collar", "shoulder", "elbow", "wrist")


def rig_of(
    name: str,
    trunk: str,
    limbs: str,
    sides: tuple[str, str],
    fingers: str = "",
    named: str = "",
    prefix: str = "",
) -> NameMap:
    """Return a known rig. trunk: names of pelvis, spine1 to 3, neck and head, "-" for none; limbs: of _LIMBS, with
    alternatives between bars. named: the rig's words for FINGERS, where they are not the same."""
    joints = ("pelvis", "spine1", "spine2", "spine3", "neck", "head")
    bones = {joint: tuple(words.split("|")) for joint, words in zip(joints, trunk.split(), strict=True)}
    bones = {joint: words for joint, words in bones.items() if words != ("-",)}
    parts = {joint: words.replace("|", " ") for joint, words in zip(_LIMBS, limbs.split(), strict=True)}
    words = dict(zip(FINGERS, named.split(), strict=False))
    both = sides_of(parts, fingers, words, sides)
    return NameMap(name, bones | {joint: found for joint, found in both.items() if found != ("",)}, prefix)
