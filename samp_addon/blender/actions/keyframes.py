"""Writes a Motion as an ordinary Action of an SMPL-X armature, and reads it back."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames, rotation, skeleton
from ...body import proportions
from ...body.hands import complete
from ...errors import SampError
from ...motion import Motion
from ...rotation import change_basis
from .. import compat
from ..character.armature import Calibration, calibrate, find
from . import channels, notes


@dataclass(frozen=True)
class Channel:
    """Values (T, n) of one property of one bone; (1, n) if constant."""

    bone: str
    path: str
    values: np.ndarray


def frames_per_second(scene: bpy.types.Scene) -> float:
    """Return the scene's frame rate."""
    return scene.render.fps / scene.render.fps_base


def write_motion(
    armature: bpy.types.Object,
    motion: Motion,
    name: str = "SAMP take",
    frame_start: int = 1,
    scene: bpy.types.Scene | None = None,
    activate: bool = True,
) -> bpy.types.Action:
    """Write a motion as a new Action and, if ``activate``, make it the armature's active one.

    armature: any SMPL-X armature, at any place. scene: its frame rate is the Action's; by default that of
    bpy.context. A motion of other proportions is adapted (body/proportions.py). Only the new Action is added;
    the previously active Action gets a fake user, so that it is saved. Raise SampError for another rig, for a
    motion with NaN or infinite values, and where Blender does not allow a new Action.
    """
    scene = scene or bpy.context.scene
    _require_valid(motion)
    if activate:
        require_editable(armature)
    calibration = calibrate(armature)
    motion = proportions.adapt(motion, calibration.rest_joints).resampled(frames_per_second(scene))
    action = bpy.data.actions.new(name)
    action.use_fake_user = True
    writer = compat.CurveWriter(action, armature)
    times = np.arange(frame_start, frame_start + len(motion), dtype=np.float64)
    for channel in motion_channels(armature, calibration, motion):
        path = f'pose.bones["{bpy.utils.escape_identifier(channel.bone)}"].{channel.path}'
        for k in range(channel.values.shape[1]):
            writer.add(path, k, times[: len(channel.values)], channel.values[:, k], channel.bone)
    notes.write_motion(action, motion, frame_start)
    action[notes.CHARACTER_KEY] = armature.name
    if activate:
        activate_action(armature, action)
    return action


def activate_action(armature: bpy.types.Object, action: bpy.types.Action, slot: object | None = None) -> None:
    """Make an Action the active one and keep the previous one in the file. slot: the Action's slot, if known."""
    data = armature.animation_data
    if data is not None and data.action is not None and data.action != action:
        data.action.use_fake_user = True
    compat.assign(armature, action, slot)


def _require_valid(motion: Motion) -> None:
    """Raise SampError for a motion that no armature can show."""
    if len(motion) == 0:
        raise SampError("The take has no frames; generate it again.")
    if motion.rotations.shape[1] < skeleton.BODY_COUNT:
        raise SampError(
            f"The take has {motion.rotations.shape[1]} joints; a body needs {skeleton.BODY_COUNT}."
        )
    if not (np.isfinite(motion.root).all() and np.isfinite(motion.rotations).all()):
        raise SampError(
            "The take has values that are not finite numbers; generate it again with another seed."
        )


def require_editable(armature: bpy.types.Object) -> None:
    """Raise SampError if Blender does not allow a new Action on the armature."""
    if not armature.is_editable:
        raise SampError(
            f"'{armature.name}' is linked from another file; make a library override of it first."
        )
    data = armature.animation_data
    if data is not None and data.use_tweak_mode:
        raise SampError(
            f"'{armature.name}' is in tweak mode of the NLA editor; leave tweak mode (Tab) first."
        )


def motion_channels(armature: bpy.types.Object, calibration: Calibration, motion: Motion) -> list[Channel]:
    """Return the pelvis location, each bone's rotation, and rest values of other channels that would interfere."""
    pose = armature.pose.bones
    result = []
    for bone in calibration.ancestors:
        path, size = channels.rotation_channel(pose[bone].rotation_mode)
        for kind, count in (("location", 3), (path, size)):
            result.append(Channel(bone, kind, np.array([channels.rest_values(kind, count)])))
    result.append(Channel(calibration.bones[0], "location", pelvis_locations(calibration, motion.root)))
    quaternions = bone_rotations(calibration, complete(motion.rotations))
    for j, bone in enumerate(calibration.bones):
        if bone is None:
            continue
        mode = pose[bone].rotation_mode
        path, _ = channels.rotation_channel(mode)
        values = channels.from_quaternions(mode, quaternions[:, j])
        still = j >= skeleton.BODY_COUNT and np.abs(values - values[0]).max() < 1e-9
        result.append(Channel(bone, path, values[:1] if still else values))
    for bone in (*calibration.ancestors, *filter(None, calibration.bones)):
        for kind in ("location", "scale"):
            rest = channels.rest_values(kind, 3)
            placed = kind == "location" and bone in (*calibration.ancestors, calibration.bones[0])
            if not placed and np.abs(np.array(getattr(pose[bone], kind)) - rest).max() > 1e-6:
                result.append(Channel(bone, kind, np.array([rest])))
    return result


def pelvis_locations(calibration: Calibration, root: np.ndarray) -> np.ndarray:
    """Convert pelvis joint positions (T, 3), network frame, metres, to the pelvis bone's ``location`` (T, 3)."""
    inverse = np.linalg.inv(calibration.world)
    position = frames.to_blender(root) @ inverse[:3, :3].T + inverse[:3, 3]
    return (position - calibration.pelvis_head) @ calibration.bases[0]


def bone_rotations(calibration: Calibration, rotations: np.ndarray) -> np.ndarray:
    """Convert SMPL-X local rotations (T, 55, 4), network frame, to each bone's own quaternions (T, 55, 4)."""
    own = change_basis(rotations, calibration.axes)
    own[:, 0] = rotation.multiply(_root_turn(calibration), own[:, 0])
    return change_basis(own, np.swapaxes(calibration.bases, 1, 2))


def _root_turn(calibration: Calibration) -> np.ndarray:
    """Return the root's rotation from the network frame to the armature: quaternion (4,) in the armature's axes."""
    return rotation.matrix_to_quaternion(
        calibration.turn.T @ frames.BLENDER_FROM_NETWORK @ calibration.axes.T
    )


def action_of(armature: bpy.types.Object, name: str = "") -> bpy.types.Action:
    """Return the Action of this name, or the armature's active one. Raise SampError where there is none."""
    data = armature.animation_data
    action = bpy.data.actions.get(name) if name else data and data.action
    if action is None:
        problem = f"There is no Action '{name}'" if name else f"'{armature.name}' has no Action"
        raise SampError(f"{problem}; generate or choose a take first.")
    return action


def find_action(
    context: bpy.types.Context, character: str = "", name: str = ""
) -> tuple[bpy.types.Object, bpy.types.Action]:
    """Return a character (see armature.find) and its Action (see action_of). Raise SampError where there is none."""
    owner = find(context, character)
    return owner, action_of(owner, name)


def read_motion(
    armature: bpy.types.Object,
    action: bpy.types.Action | None = None,
    frame_start: int | None = None,
    frame_end: int | None = None,
    scene: bpy.types.Scene | None = None,
    reader: Reader | None = None,
) -> Motion:
    """Return the Motion (55 joints) of an Action, with the armature where it is now: the inverse of write_motion.

    Samples the f-curves at each frame of the scene's rate; constraints and NLA strips are ignored unless ``reader``,
    of the same frames, sees them (takes/seen.py). action:
    by default the active one. frame_start, frame_end: by default the Action's range. Raise SampError where
    there is no Action.
    """
    scene = scene or bpy.context.scene
    action = action or action_of(armature)
    calibration = calibrate(armature)
    start = int(np.floor(action.frame_range[0])) if frame_start is None else frame_start
    end = int(np.ceil(action.frame_range[1])) if frame_end is None else frame_end
    if end < start:
        raise SampError(f"Frame range {start} to {end} is empty; set the end after the start.")
    reader = reader or Reader(armature, action, np.arange(start, end + 1))
    location, quaternions = reader.pelvis_and_rotations(calibration)
    own = change_basis(quaternions, calibration.bases)
    own[:, 0] = rotation.multiply(rotation.conjugate(_root_turn(calibration)), own[:, 0])
    position = location @ calibration.world[:3, :3].T + calibration.world[:3, 3]
    return Motion(
        root=frames.to_network(position),
        rotations=rotation.continuous(change_basis(own, calibration.axes.T)),
        fps=frames_per_second(scene),
        rest_joints=calibration.rest_joints,
        **notes.read_motion(action, start, end),
    )


class Reader:
    """Samples an Action's f-curves; a property without a curve keeps the pose's value."""

    def __init__(self, armature: bpy.types.Object, action: bpy.types.Action, times: np.ndarray) -> None:
        self.pose = armature.pose.bones
        self.times = times
        self.curves = {
            (curve.data_path, curve.array_index): curve for curve in compat.curves(action, armature)
        }

    def values(self, bone: str, path: str, size: int) -> np.ndarray:
        """Return one property of a bone over the frames, (T, size)."""
        posed = getattr(self.pose[bone], path)
        result = np.empty((len(self.times), size))
        for k in range(size):
            curve = self.curves.get((f'pose.bones["{bpy.utils.escape_identifier(bone)}"].{path}', k))
            result[:, k] = posed[k] if curve is None else _sampled(curve, self.times)
        return result

    def quaternions(self, bone: str) -> np.ndarray:
        """Return a bone's own rotation over the frames, (T, 4)."""
        mode = self.pose[bone].rotation_mode
        return channels.to_quaternions(mode, self.values(bone, *channels.rotation_channel(mode)))

    def pelvis_and_rotations(self, calibration: Calibration) -> tuple[np.ndarray, np.ndarray]:
        """Return the pelvis head (T, 3) in the armature's units, and each bone's own quaternions (T, 55, 4).

        Transforms of bones above the pelvis are folded into the pelvis.
        """
        result = np.tile([1.0, 0.0, 0.0, 0.0], (len(self.times), len(calibration.bones), 1))
        for j, bone in enumerate(calibration.bones):
            if bone is not None:
                result[:, j] = self.quaternions(bone)
        base = calibration.bases[0]
        position = calibration.pelvis_head + self.values(calibration.bones[0], "location", 3) @ base.T
        whole = change_basis(result[:, 0], base)
        for head, turn, shift in self.ancestors(calibration):
            position = rotation.rotate(turn, position - head) + head + shift
            whole = rotation.multiply(turn, whole)
        result[:, 0] = change_basis(whole, base.T)
        return position, result

    def ancestors(self, calibration: Calibration) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Return head (3,), rotation (T, 4) and translation (T, 3) of each bone above the pelvis, nearest first.

        In the armature's axes and units.
        """
        result = []
        for bone in calibration.ancestors:
            rest = np.array(self.pose[bone].bone.matrix_local, dtype=np.float64)
            turn = change_basis(self.quaternions(bone), rest[:3, :3])
            result.append((rest[:3, 3], turn, self.values(bone, "location", 3) @ rest[:3, :3].T))
        return result


def _sampled(curve: bpy.types.FCurve, times: np.ndarray) -> np.ndarray:
    """Return an f-curve's values (T,) at frames (T,).

    Curves of takes have one key per frame, or a single one: their keys are read in bulk.
    """
    keys = curve.keyframe_points
    if len(keys) in (1, len(times)) and not curve.modifiers:
        places = np.empty((len(keys), 2), np.float32)
        keys.foreach_get("co", places.reshape(-1))
        if len(keys) == 1 or np.array_equal(places[:, 0], times):
            return places[:, 1]
    return np.array([curve.evaluate(time) for time in times])
