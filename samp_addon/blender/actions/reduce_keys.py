"""Copies a take with fewer keys, so that its curves can be edited by hand; within a bound on each bone's error."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ...edits import key_reduction
from ...edits.key_reduction import Error
from ...errors import SampError
from .. import compat
from ..character.armature import Calibration, calibrate
from . import channels, keyframes
from .action_names import derived_name
from .curve_keys import CurveKeys

SUFFIX = " reduced"
METRES, DEGREES = 0.001, 0.1
"""Default bounds: of the pelvis' place, and of each bone's rotation relative to its parent."""


@dataclass(frozen=True)
class Reduced:
    """The new Action, and how many keys the bones' curves had before and have after."""

    action: bpy.types.Action
    before: int
    after: int

    def sentence(self) -> str:
        """Return a summary."""
        return f"'{self.action.name}' has {self.after} keys instead of {self.before}."


def run(
    owner: bpy.types.Object, action: bpy.types.Action, metres: float = METRES, degrees: float = DEGREES
) -> Reduced:
    """Write a copy of an Action with fewer keys and make it the owner's active one; the source stays unchanged.

    Channels of bones with one key on each frame are reduced; others keep their keys. metres, degrees: bounds on the
    error of the pelvis' place and of each bone's own rotation, in every frame. Raise SampError where nothing can be
    reduced or Blender does not allow a new Action.
    """
    keyframes.require_editable(owner)
    calibration = calibrate(owner)
    times = np.arange(*(np.round(action.frame_range).astype(int) + [0, 1]))
    reader = keyframes.Reader(owner, action, times)
    before = after = 0
    found = []
    for bone, path, size, error, bound in _channels(owner, calibration, metres, np.radians(degrees)):
        data_path = f'pose.bones["{bpy.utils.escape_identifier(bone)}"].{path}'
        curves = [reader.curves.get((data_path, k)) for k in range(size)]
        if any(curve is None or not _dense(curve, times) for curve in curves):
            continue
        values = reader.values(bone, path, size).astype(np.float64)
        keys = key_reduction.reduced(values, error, bound)
        before, after = before + size * len(times), after + size * len(keys.frames)
        found.append((data_path, values, keys))
    if not found:
        raise SampError(f"'{action.name}' has no keys on each frame; there is nothing to reduce.")
    writer = compat.CurveWriter.on_copy(action, owner)
    writer.action.name, writer.action.use_fake_user = derived_name(action, SUFFIX), True
    for data_path, values, keys in found:
        for k in range(values.shape[1]):
            own = CurveKeys.cubic(times[keys.frames], values[keys.frames, k], keys.slopes[:, :, k])
            own.replace_in(writer.find(data_path, k))
    if action.library is None:
        action.use_fake_user = True
    keyframes.activate_action(owner, writer.action, writer.slot)
    return Reduced(writer.action, before, after)


def _channels(
    owner: bpy.types.Object, calibration: Calibration, metres: float, radians: float
) -> Iterator[tuple[str, str, int, Error, float]]:
    """Yield bone, property, size, error measure and bound of each channel that a take can move."""
    scale = float(np.abs(np.linalg.det(calibration.world[:3, :3])) ** (1 / 3))
    yield calibration.bones[0], "location", 3, key_reduction.distance_error, metres / scale
    for bone in filter(None, calibration.bones):
        mode = owner.pose.bones[bone].rotation_mode
        path, size = channels.rotation_channel(mode)
        yield bone, path, size, _rotation_error(mode), radians


def _rotation_error(mode: str) -> Error:
    """Return the measure of a rotation mode: the angle, or for Euler angles a bound on it."""
    if mode == "QUATERNION":
        return key_reduction.angle_error
    if mode == "AXIS_ANGLE":
        turned = lambda values: channels.to_quaternions(mode, values)
        return lambda made, true: key_reduction.angle_error(turned(made), turned(true))
    return lambda made, true: np.abs(made - true).sum(-1)


def _dense(curve: bpy.types.FCurve, times: np.ndarray) -> bool:
    """Whether a curve has one key on each frame and nothing that changes them."""
    keys = curve.keyframe_points
    if len(keys) != len(times) or curve.modifiers:
        return False
    places = np.empty(2 * len(keys), np.float32)
    keys.foreach_get("co", places)
    return bool(np.abs(places[::2] - times).max() < 1e-3)
