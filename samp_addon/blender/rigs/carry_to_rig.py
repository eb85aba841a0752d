"""Carries a take from an SMPL-X armature to another rig, as a new Action of that rig."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ... import skeleton
from ...body import human
from ...errors import SampError
from ...motion import Motion
from ...rigs import guessing, maps, retargeting
from ...rigs.rig import Rig
from .. import compat
from ..actions import channels, keyframes, notes
from ..character import armature, character, characters
from . import bone_table, read_rig

REPORTED = 0.01
"""Metres: foot errors above this are reported."""


@dataclass(frozen=True)
class Result:
    """The carried take.

    action: the new Action of the rig ``owner``. source: the take's Action. known: kind of the rig, or "bone table".
    body_joints: how many of the 22 have a bone. missed: largest position error of a standing foot, metres. switched:
    how many properties of the rig the Action sets to switch it to FK. constrained: keyed bones that have constraints
    too, which may override the keys.
    """

    owner: bpy.types.Object
    action: bpy.types.Action
    source: bpy.types.Action
    known: str
    body_joints: int
    missed: float
    switched: int
    constrained: tuple[str, ...]


@dataclass(frozen=True)
class Guess:
    """A filled bone table. known: kind of the rig, or "" for a guess. missing: body joints without a bone."""

    owner: bpy.types.Object
    known: str
    missing: tuple[str, ...]


def carry_to_rig(
    context: bpy.types.Context,
    target: str = "",
    character_name: str = "",
    action_name: str = "",
    frame_start: int | None = None,
    frame_end: int | None = None,
) -> Result:
    """Carry a take to another armature and make it that armature's active Action.

    target: the armature; empty: the active one. character_name: the SMPL-X armature with the take; empty: the
    selected one, or the only other one. action_name: the take; empty: its active Action. frame_start, frame_end: in
    the scene's frames; by default the whole take. Only the new Action is added. Raise SampError where one of these
    is missing, or the target's bones are not those of a body.
    """
    owner = find_target(context, target)
    source = _source(context, character_name, owner)
    take = keyframes.action_of(source, action_name)
    keyframes.require_editable(owner)
    start = int(np.floor(take.frame_range[0])) if frame_start is None else frame_start
    motion = keyframes.read_motion(source, take, start, frame_end, context.scene)
    known, bones = bones_of(owner)
    rig = read_rig.read(context, owner)
    _require_movable(owner, bones.get("pelvis", ""))
    carried = retargeting.retarget(motion, rig, bones, character.body_of(source).vertices)
    action = bpy.data.actions.new(f"{take.name} on {owner.name}")
    try:
        switched = _write(owner, rig, carried, action, start)
    except BaseException:
        bpy.data.actions.remove(action)
        raise
    action.use_fake_user = True
    action[characters.CARRIED] = {"action": take.name, "armature": source.name, "rig": owner.name}
    keyframes.activate_action(owner, action)
    body = sum(joint in bones for joint in skeleton.BODY_JOINTS)
    constrained = tuple(rig.names[link.bone] for link in carried.fit.links if rig.constrained[link.bone])
    return Result(owner, action, take, known, body, carried.missed(), switched, constrained)


def write_take(
    context: bpy.types.Context, owner: bpy.types.Object, motion: Motion, name: str, frame_start: int
) -> tuple[bpy.types.Action, list[str]]:
    """Write a motion of the default human as a new Action of a rig, which stays inactive.

    Return it, and a sentence for each thing that is not exact. Raise SampError as `carry_to_rig` does.
    """
    _, bones = bones_of(owner)
    rig = read_rig.read(context, owner)
    _require_movable(owner, bones.get("pelvis", ""))
    motion = motion.resampled(keyframes.frames_per_second(context.scene))
    carried = retargeting.retarget(motion, rig, bones, human.load().vertices)
    action = bpy.data.actions.new(name)
    try:
        _write(owner, rig, carried, action, frame_start)
    except BaseException:
        bpy.data.actions.remove(action)
        raise
    action.use_fake_user = True
    action[characters.CARRIED] = {"action": "", "armature": "", "rig": owner.name}
    notes.write_motion(action, motion, frame_start)
    action[notes.CHARACTER_KEY] = owner.name
    missed = carried.missed()
    off = f"A foot of '{owner.name}' is up to {100 * missed:.0f} cm off its place: the legs are too short to reach it."
    return action, [off] if missed > REPORTED else []


def guess_map(context: bpy.types.Context, target: str = "", keep: bool = True) -> Guess:
    """Fill the bone table of an armature, by default the active one. keep: do not change rows with a valid bone.

    Raise SampError where there is no such armature, or it cannot be edited.
    """
    owner = find_target(context, target)
    rig = read_rig.read(context, owner)
    found = maps.recognise(rig.names)
    bones = guessing.guess(rig.names, rig.parents, rig.heads) if found is None else found[1]
    bone_table.fill(owner, bones, keep)
    filled = bone_table.read(owner)
    missing = tuple(joint for joint in skeleton.BODY_JOINTS if joint not in filled)
    return Guess(owner, "" if found is None else found[0].name, missing)


def sentence(result: Result) -> str:
    """Return a summary of a carried take."""
    text = (
        f"Carried '{result.source.name}' to '{result.owner.name}' ({result.known}) as '{result.action.name}'."
    )
    if result.switched:
        text += " The Action switches its limbs to FK."
    if result.constrained:
        text += f" Constraints may override {', '.join(result.constrained)}; mute them if so."
    if result.missed > REPORTED:
        text += f" A foot is up to {result.missed * 100:.0f} cm off its position: the legs are too short to reach it."
    return text


def guess_sentence(guess: Guess) -> str:
    """Return a summary of a filled bone table."""
    text = (
        f"'{guess.owner.name}' is a {guess.known} rig"
        if guess.known
        else "Guessed the bones from their names"
    )
    if guess.missing:
        return f"{text}; no bone was found for {', '.join(guess.missing)}."
    return f"{text}; every joint of the body has a bone."


def find_target(context: bpy.types.Context, name: str = "") -> bpy.types.Object:
    """Return the armature of this name, or the active one, or the active mesh's. Raise SampError if there is none."""
    if name:
        obj = context.scene.objects.get(name)
        if obj is None:
            raise SampError(f"The scene has no object '{name}'; name an armature that is in it.")
    else:
        obj = context.view_layer.objects.active
    owner = obj if obj is None or obj.type == "ARMATURE" else obj.find_armature()
    if owner is None:
        raise SampError("No armature is active; select the rig that receives the take.")
    return owner


def _source(context: bpy.types.Context, name: str, owner: bpy.types.Object) -> bpy.types.Object:
    """Return the SMPL-X armature that has the take."""
    if name:
        source = armature.find(context, name)
        if source == owner:
            raise SampError(f"'{owner.name}' has the take already; name another armature to carry it to.")
        return source
    others = [obj for obj in context.scene.objects if obj != owner and armature.is_smplx(obj)]
    chosen = [obj for obj in others if obj.select_get()] or others
    if len(chosen) == 1:
        return chosen[0]
    if not chosen:
        raise SampError("The scene has no other SMPL-X armature; make the rig that receives the take active.")
    names = ", ".join(f"'{obj.name}'" for obj in chosen)
    raise SampError(
        f"The scene has several characters ({names}); select the one with the take, then the rig."
    )


def bones_of(owner: bpy.types.Object) -> tuple[str, dict[str, str]]:
    """Return the kind of rig, and joint -> bone: from the bone table if filled, or else from known names.

    Raise SampError for a rig that is neither.
    """
    table = bone_table.read(owner)
    if table:
        return "bone table", table
    found = maps.recognise(bone.name for bone in owner.data.bones)
    if found is None:
        raise SampError(
            f"'{owner.name}' is not a known rig; press Guess Bones, check the bone table and carry again."
        )
    return found[0].name, found[1]


def _require_movable(owner: bpy.types.Object, pelvis: str) -> None:
    """Raise SampError where the pelvis bone cannot be moved."""
    bone = owner.data.bones.get(pelvis)
    if bone is not None and bone.use_connect and bone.parent is not None:
        raise SampError(f"Bone '{pelvis}' of '{owner.name}' cannot move; turn off Connected.")


def _write(
    owner: bpy.types.Object, rig: Rig, carried: retargeting.Retargeted, action: bpy.types.Action, start: int
) -> int:
    """Key all bones that move, and rest values of channels that would interfere; return the number of switches set."""
    writer, pose = compat.CurveWriter(action, owner), owner.pose.bones
    times = np.arange(start, start + len(carried.motion), dtype=np.float64)

    def add(bone: str, path: str, values: np.ndarray) -> None:
        whole = f'pose.bones["{bpy.utils.escape_identifier(bone)}"].{path}'
        for k in range(values.shape[1]):
            writer.add(whole, k, times[: len(values)], values[:, k], bone)

    keyed = [rig.names[link.bone] for link in carried.fit.links]
    add(keyed[0], "location", _location(owner, rig, carried))
    for k, bone in enumerate(keyed):
        mode = pose[bone].rotation_mode
        path, _ = channels.rotation_channel(mode)
        values = channels.from_quaternions(mode, carried.rotations[:, k])
        still = k > 0 and np.abs(values - values[0]).max() < 1e-9
        add(bone, path, values[:1] if still else values)
    for bone, path, values in _interfering(owner, rig, keyed):
        add(bone, path, values)
    switches = list(_switches(owner, keyed))
    for bone, name, value in switches:
        path = f'pose.bones["{bpy.utils.escape_identifier(bone)}"]["{bpy.utils.escape_identifier(name)}"]'
        writer.add(path, 0, times[:1], np.array([value]), bone)
    return len(switches)


def _location(owner: bpy.types.Object, rig: Rig, carried: retargeting.Retargeted) -> np.ndarray:
    """Return the pelvis bone's location channel (T, 3), along the bone's own axes or the armature's."""
    bone = carried.fit.links[0].bone
    if owner.data.bones[rig.names[bone]].use_local_location:
        return carried.location
    above = int(rig.parents[bone])
    turn = rig.bases[bone] if above < 0 else rig.bases[above].T @ rig.bases[bone]
    return carried.location @ turn.T


def _interfering(
    owner: bpy.types.Object, rig: Rig, keyed: list[str]
) -> Iterator[tuple[str, str, np.ndarray]]:
    """Yield bone, property and rest value (1, n) of channels that would interfere with the keyed bones.

    These are posed channels of the keyed bones, of the bones above them, and of the targets of their constraints.
    """
    pose, related = owner.pose.bones, set()
    for bone in keyed:
        for upper in rig.above(rig.index(bone)):
            related.add(rig.names[upper])
            for constraint in pose[rig.names[upper]].constraints:
                if getattr(constraint, "target", None) == owner and constraint.subtarget in pose:
                    related.add(constraint.subtarget)
    for bone in sorted(related | set(keyed)):
        path, size = channels.rotation_channel(pose[bone].rotation_mode)
        for kind, count in (("location", 3), (path, size), ("scale", 3)):
            if bone in keyed and (kind == path or (kind == "location" and bone == keyed[0])):
                continue
            rest = np.array(channels.rest_values(kind, count))
            posed = np.array(getattr(pose[bone], kind))
            if np.abs(posed - rest).max() > 1e-6 and not (
                kind == "rotation_axis_angle" and abs(posed[0]) < 1e-6
            ):
                yield bone, kind, rest[None]


def _switches(owner: bpy.types.Object, keyed: list[str]) -> Iterator[tuple[str, str, float]]:
    """Yield bone, custom property and value that switch a Rigify rig to FK; nothing for other rigs."""
    if not any(bone in keyed for bone in maps.FOLLOWS_FOR):
        return
    for bone in owner.pose.bones:
        for name, value in maps.FOLLOWS.items():
            if name in bone:
                yield bone.name, name, value
