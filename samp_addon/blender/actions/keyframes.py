"""A Motion as an ordinary Action on an SMPL-X armature, and back."""

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
from ..character.armature import Calibration, calibrate
from ..takes.take_list import NOTES
from . import channels


@dataclass(frozen=True)
class _Channel:
    """Values (T, n) of one property of one bone; (1, n) where it holds still."""

    bone: str
    path: str
    values: np.ndarray


def frames_per_second(scene: bpy.types.Scene) -> float:
    """The scene's frame rate."""
    return scene.render.fps / scene.render.fps_base


def write_motion(
    armature: bpy.types.Object,
    motion: Motion,
    name: str = "SAMP take",
    frame_start: int = 1,
    scene: bpy.types.Scene | None = None,
    activate: bool = True,
) -> bpy.types.Action:
    """Writes a take as a new Action and, if ``activate``, makes it the armature's active one.

    armature: any SMPL-X armature, wherever it stands. scene: its frame rate is the Action's; bpy.context's
    if None. For other proportions than the take's see body/proportions.py. Nothing but the new Action is
    made; an Action that it replaces as the active one keeps a fake user, so that it is saved. Raises
    SampError for another rig, for a take with values that are not numbers, and where Blender does not allow
    a new Action.
    """
    scene = scene or bpy.context.scene
    _refuse_broken(motion)
    if activate:
        refuse_locked(armature)
    calibration = calibrate(armature)
    motion = proportions.adapt(motion, calibration.rest_joints).resampled(frames_per_second(scene))
    action = bpy.data.actions.new(name)
    action.use_fake_user = True
    writer = compat.CurveWriter(action, armature)
    times = np.arange(frame_start, frame_start + len(motion), dtype=np.float64)
    for channel in _channels(armature, calibration, motion):
        path = f'pose.bones["{bpy.utils.escape_identifier(channel.bone)}"].{channel.path}'
        for k in range(channel.values.shape[1]):
            writer.add(path, k, times[: len(channel.values)], channel.values[:, k], channel.bone)
    action[NOTES] = _notes(motion, frame_start)
    if activate:
        activate_action(armature, action)
    return action


def activate_action(armature: bpy.types.Object, action: bpy.types.Action, slot: object | None = None) -> None:
    """Makes an Action the active one; the one before it is kept in the file. slot: of the Action, if it is known."""
    data = armature.animation_data
    if data is not None and data.action is not None and data.action != action:
        data.action.use_fake_user = True
    compat.assign(armature, action, slot)


def _refuse_broken(motion: Motion) -> None:
    """Raises SampError for a take that no armature can show."""
    if len(motion) == 0:
        raise SampError("The take has no frames; generate it again.")
    if motion.rotations.shape[1] < skeleton.BODY_COUNT:
        raise SampError(
            f"The take moves {motion.rotations.shape[1]} joints; a body needs {skeleton.BODY_COUNT}."
        )
    if not (np.isfinite(motion.root).all() and np.isfinite(motion.rotations).all()):
        raise SampError("The take holds values that are not numbers; generate it again with another seed.")


def refuse_locked(armature: bpy.types.Object) -> None:
    """Raises SampError where Blender would not let the armature have a new Action."""
    if not armature.is_editable:
        raise SampError(
            f"'{armature.name}' is linked from another file; make a library override of it first."
        )
    data = armature.animation_data
    if data is not None and data.use_tweak_mode:
        raise SampError(f"'{armature.name}' is in tweak mode of the NLA editor; leave it (Tab) first.")


def _channels(armature: bpy.types.Object, calibration: Calibration, motion: Motion) -> list[_Channel]:
    """The pelvis' place, each bone's rotation, and the rest pose of whatever else would disturb."""
    pose = armature.pose.bones
    result = []
    for bone in calibration.ancestors:
        path, size = channels.rotation_channel(pose[bone].rotation_mode)
        for kind, count in (("location", 3), (path, size)):
            result.append(_Channel(bone, kind, np.array([channels.rest_values(kind, count)])))
    result.append(_Channel(calibration.bones[0], "location", pelvis_locations(calibration, motion.root)))
    quaternions = bone_rotations(calibration, complete(motion.rotations))
    for j, bone in enumerate(calibration.bones):
        if bone is None:
            continue
        mode = pose[bone].rotation_mode
        path, _ = channels.rotation_channel(mode)
        values = channels.from_quaternions(mode, quaternions[:, j])
        still = j >= skeleton.BODY_COUNT and np.abs(values - values[0]).max() < 1e-9
        result.append(_Channel(bone, path, values[:1] if still else values))
    for bone in (*calibration.ancestors, *filter(None, calibration.bones)):
        for kind in ("location", "scale"):
            rest = channels.rest_values(kind, 3)
            placed = kind == "location" and bone in (*calibration.ancestors, calibration.bones[0])
            if not placed and np.abs(np.array(getattr(pose[bone], kind)) - rest).max() > 1e-6:
                result.append(_Channel(bone, kind, np.array([rest])))
    return result


def pelvis_locations(calibration: Calibration, root: np.ndarray) -> np.ndarray:
    """The pelvis bone's ``location`` (T, 3) for the pelvis joint (T, 3) in the network frame, metres."""
    inverse = np.linalg.inv(calibration.world)
    place = frames.to_blender(root) @ inverse[:3, :3].T + inverse[:3, 3]
    return (place - calibration.pelvis_head) @ calibration.bases[0]


def bone_rotations(calibration: Calibration, rotations: np.ndarray) -> np.ndarray:
    """Each bone's own quaternions (T, 55, 4) for SMPL-X local rotations (T, 55, 4) of the network frame."""
    own = change_basis(rotations, calibration.axes)
    own[:, 0] = rotation.multiply(_border(calibration), own[:, 0])
    return change_basis(own, np.swapaxes(calibration.bases, 1, 2))


def _border(calibration: Calibration) -> np.ndarray:
    """Quaternion (4,): a root turn, seen in the armature's axes, from the network's world to the armature."""
    return rotation.matrix_to_quaternion(
        calibration.turn.T @ frames.BLENDER_FROM_NETWORK @ calibration.axes.T
    )


def _notes(motion: Motion, frame_start: int) -> dict:
    """What read_motion cannot see in keyframes."""
    notes = {"frame_start": frame_start, "frame_end": frame_start + len(motion) - 1}
    if motion.interaction_start is not None:
        notes["interaction_start"] = frame_start + motion.interaction_start
    for key in ("contacts", "actions"):
        values = getattr(motion, key)
        if values is not None:
            notes[key] = values.astype(float).ravel().tolist()
    return notes


def read_motion(
    armature: bpy.types.Object,
    action: bpy.types.Action | None = None,
    frame_start: int | None = None,
    frame_end: int | None = None,
    scene: bpy.types.Scene | None = None,
) -> Motion:
    """The inverse of write_motion: the Motion (55 joints) that an Action shows where the armature stands.

    Reads the f-curves themselves, frame by frame at the scene's rate; constraints and NLA strips are not
    seen. Without ``action`` the active one, without frames all of it. Raises SampError where there is no
    Action.
    """
    scene = scene or bpy.context.scene
    data = armature.animation_data
    action = action or (data.action if data else None)
    if action is None:
        raise SampError(f"'{armature.name}' has no Action; generate or choose a take first.")
    calibration = calibrate(armature)
    start = int(np.floor(action.frame_range[0])) if frame_start is None else frame_start
    end = int(np.ceil(action.frame_range[1])) if frame_end is None else frame_end
    if end < start:
        raise SampError(f"The frames {start} to {end} are none; give an end after the start.")
    reader = Reader(armature, action, np.arange(start, end + 1))
    location, quaternions = reader.pelvis_and_rotations(calibration)
    own = change_basis(quaternions, calibration.bases)
    own[:, 0] = rotation.multiply(rotation.conjugate(_border(calibration)), own[:, 0])
    place = location @ calibration.world[:3, :3].T + calibration.world[:3, 3]
    return Motion(
        root=frames.to_network(place),
        rotations=rotation.continuous(change_basis(own, calibration.axes.T)),
        fps=frames_per_second(scene),
        rest_joints=calibration.rest_joints,
        **_noted(action, start, end),
    )


class Reader:
    """Samples an Action's f-curves; a property without a curve holds the pose's value."""

    def __init__(self, armature: bpy.types.Object, action: bpy.types.Action, times: np.ndarray) -> None:
        self.pose = armature.pose.bones
        self.times = times
        self.curves = {
            (curve.data_path, curve.array_index): curve for curve in compat.curves(action, armature)
        }

    def values(self, bone: str, path: str, size: int) -> np.ndarray:
        """One property of a bone over the frames: (T, size)."""
        held = getattr(self.pose[bone], path)
        result = np.empty((len(self.times), size))
        for k in range(size):
            curve = self.curves.get((f'pose.bones["{bpy.utils.escape_identifier(bone)}"].{path}', k))
            result[:, k] = held[k] if curve is None else _sampled(curve, self.times)
        return result

    def quaternions(self, bone: str) -> np.ndarray:
        """A bone's own rotation over the frames: (T, 4)."""
        mode = self.pose[bone].rotation_mode
        return channels.to_quaternions(mode, self.values(bone, *channels.rotation_channel(mode)))

    def pelvis_and_rotations(self, calibration: Calibration) -> tuple[np.ndarray, np.ndarray]:
        """The pelvis head (T, 3) in the armature's units, and each bone's own quaternions (T, 55, 4).

        Bones above the pelvis are folded into the pelvis.
        """
        result = np.tile([1.0, 0.0, 0.0, 0.0], (len(self.times), len(calibration.bones), 1))
        for j, bone in enumerate(calibration.bones):
            if bone is not None:
                result[:, j] = self.quaternions(bone)
        base = calibration.bases[0]
        place = calibration.pelvis_head + self.values(calibration.bones[0], "location", 3) @ base.T
        whole = change_basis(result[:, 0], base)
        for head, turn, shift in self.ancestors(calibration):
            place = rotation.rotate(turn, place - head) + head + shift
            whole = rotation.multiply(turn, whole)
        result[:, 0] = change_basis(whole, base.T)
        return place, result

    def ancestors(self, calibration: Calibration) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """For each bone above the pelvis, the nearest first: its head (3,), and how it turns (T, 4) and shifts (T, 3)
        what hangs from it; in the armature's axes and units."""
        result = []
        for bone in calibration.ancestors:
            rest = np.array(self.pose[bone].bone.matrix_local, dtype=np.float64)
            turn = change_basis(self.quaternions(bone), rest[:3, :3])
            result.append((rest[:3, 3], turn, self.values(bone, "location", 3) @ rest[:3, :3].T))
        return result


def _sampled(curve: bpy.types.FCurve, times: np.ndarray) -> np.ndarray:
    """An f-curve's values (T,) at frames (T,): those of its keys where it has just these, or one, as takes have."""
    keys = curve.keyframe_points
    if len(keys) in (1, len(times)) and not curve.modifiers:
        places = np.empty((len(keys), 2), np.float32)
        keys.foreach_get("co", places.reshape(-1))
        if len(keys) == 1 or np.array_equal(places[:, 0], times):
            return places[:, 1]
    return np.array([curve.evaluate(time) for time in times])


def _noted(action: bpy.types.Action, start: int, end: int) -> dict:
    """Contacts, actions and the interaction's start, where the Action carries them for all these frames."""
    notes = action.get(NOTES)
    if notes is None or start < notes["frame_start"] or end > notes["frame_end"]:
        return {}
    chosen = slice(start - notes["frame_start"], end + 1 - notes["frame_start"])
    total = notes["frame_end"] - notes["frame_start"] + 1
    result = {
        key: np.array(notes[key][:], dtype=np.float64).reshape(total, -1)[chosen]
        for key in ("contacts", "actions")
        if key in notes
    }
    if start <= notes.get("interaction_start", start - 1) <= end:
        result["interaction_start"] = notes["interaction_start"] - start
    return result
