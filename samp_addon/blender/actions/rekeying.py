"""Copies an Action with part of its motion replaced; channels that do not change keep their keys.

Within the part, changed channels get a key on each frame. Outside of it the animation stays the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ... import frames, rotation
from ...body.hands import complete
from ...easing import smoothstep
from ...motion import Motion
from .. import compat
from ..character.armature import Calibration, calibrate
from . import channels, keyframes
from .curve_keys import CurveKeys, choice

FADE_SECONDS = 0.3
"""Length of the blend where the part borders on frames that stay."""

UNCHANGED = 1e-5  # metres, or half an angle in radians: below this a difference is rounding
_SAME_FRAME = 1e-3  # frames: keys nearer than this count as one


def frame_span(action: bpy.types.Action) -> tuple[int, int]:
    """Return first and last frame of an Action: the union of its keys and its manual frame range."""
    (first, last), (own_first, own_last) = action.curve_frame_range, action.frame_range
    return int(np.floor(min(first, own_first))), int(np.ceil(max(last, own_last)))


def fade_weights(count: int, before: bool, after: bool, fps: float) -> np.ndarray:
    """Return the weight (T,) of the change in each frame. before, after: whether other frames border on the part."""
    length = max(min(FADE_SECONDS * fps, count / 3), 1.0)
    at, weights = np.arange(count), np.ones(count)
    if before:
        weights *= smoothstep(at / length)
    if after:
        weights *= smoothstep((count - 1 - at) / length)
    return weights


def blend(old: Motion, new: Motion, weights: np.ndarray) -> Motion:
    """Blend two motions of equal length: ``old`` where weights (T,) are 0, ``new`` where they are 1."""
    rotations = old.rotations.copy()
    joints = min(rotations.shape[1], new.rotations.shape[1])
    mixed = rotation.slerp(rotations[:, :joints], new.rotations[:, :joints], weights[:, None])
    rotations[:, :joints] = mixed
    root = old.root + weights[:, None] * (new.root - old.root)
    return replace(old, root=root, rotations=rotations)


def rekey_copy(
    armature: bpy.types.Object,
    action: bpy.types.Action,
    old: Motion,
    new: Motion,
    frame_start: int,
    name: str,
) -> tuple[bpy.types.Action, object]:
    """Return a copy of an Action with ``new`` in place of ``old``, which was read from frame_start on; and its slot.

    Bones above the pelvis and channels that a Motion does not have keep their curves. Where the Action extends
    before or after these frames, the change is faded in or out.
    """
    first, last = frame_span(action)
    times = np.arange(frame_start, frame_start + len(old))
    weights = fade_weights(len(old), frame_start > first, times[-1] < last, old.fps)
    motion = blend(old, new, weights)
    writer = compat.CurveWriter.on_copy(action, armature)
    try:
        writer.action.name, writer.action.use_fake_user = name, True
        rekey = _Rekey(writer, times, np.arange(min(first, times[0]), max(last, times[-1]) + 1))
        for bone, path, before, after in _changed(armature, action, old, motion, times):
            # Exactly the old values where the weight is 0, so that the curve continues without a step.
            values = np.where(weights[:, None] > 0, after, before)
            for k in range(values.shape[1]):
                rekey(f'pose.bones["{bpy.utils.escape_identifier(bone)}"].{path}', k, values[:, k], bone)
    except BaseException:
        bpy.data.actions.remove(writer.action)
        raise
    return writer.action, writer.slot


def _changed(
    armature: bpy.types.Object, action: bpy.types.Action, old: Motion, new: Motion, times: np.ndarray
) -> list[tuple[str, str, np.ndarray, np.ndarray]]:
    """Return bone, property, and values (T, n) before and after, of each channel that differs between two motions."""
    calibration, reader = calibrate(armature), keyframes.Reader(armature, action, times)
    position, quaternions = _bone_values(calibration, reader, new)
    sides = np.where(np.sum(old.rotations * new.rotations, axis=-1, keepdims=True) < 0, -1.0, 1.0)
    turned = np.linalg.norm(new.rotations * sides - old.rotations, axis=-1).max(0) > UNCHANGED
    result = []
    if np.abs(new.root - old.root).max() > UNCHANGED or turned[0]:
        before = reader.values(calibration.bones[0], "location", 3)
        result.append((calibration.bones[0], "location", before, position))
    for j in np.flatnonzero(turned):
        bone = calibration.bones[j]
        if bone is not None:
            mode = armature.pose.bones[bone].rotation_mode
            path, size = channels.rotation_channel(mode)
            before = reader.values(bone, path, size)
            result.append((bone, path, before, channels.nearest(mode, quaternions[:, j], before)))
    return result


def _bone_values(
    calibration: Calibration, reader: keyframes.Reader, motion: Motion
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pelvis bone's location (T, 3) and all bones' own quaternions (T, 55, 4).

    Bones above the pelvis keep their animation: the inverse of ``Reader.pelvis_and_rotations``.
    """
    quaternions = keyframes.bone_rotations(calibration, complete(motion.rotations))
    base = calibration.bases[0]
    inverse = np.linalg.inv(calibration.world)
    position = frames.to_blender(motion.root) @ inverse[:3, :3].T + inverse[:3, 3]
    whole = rotation.change_basis(quaternions[:, 0], base)
    for head, turn, shift in reversed(reader.ancestors(calibration)):
        back = rotation.conjugate(turn)
        position = rotation.rotate(back, position - head - shift) + head
        whole = rotation.multiply(back, whole)
    quaternions[:, 0] = rotation.change_basis(whole, base.T)
    return (position - calibration.pelvis_head) @ base, quaternions


@dataclass(frozen=True)
class _Rekey:
    """Writes values to curves. times: (T,) frames of the values. all_times: all frames of the Action."""

    writer: compat.CurveWriter
    times: np.ndarray
    all_times: np.ndarray

    def __call__(self, path: str, index: int, values: np.ndarray, group: str) -> None:
        """Write values (T,) at the frames to one curve, which is added if missing."""
        curve = self.writer.find(path, index)
        if curve is None:
            self.writer.add(path, index, self.times, values, group)
        elif len(curve.keyframe_points) and not curve.modifiers and curve.extrapolation == "CONSTANT":
            self._replace_keys(curve, values)
        else:
            # Values from modifiers or extrapolation have no keys: bake a key on each frame.
            baked = np.array([curve.evaluate(time) for time in self.all_times])
            baked[np.searchsorted(self.all_times, self.times)] = values
            extrapolation = curve.extrapolation
            self.writer.remove(curve)
            self.writer.add(path, index, self.all_times, baked, group).extrapolation = extrapolation

    def _replace_keys(self, curve: bpy.types.FCurve, values: np.ndarray) -> None:
        keys, own = CurveKeys.of(curve), CurveKeys.linear(self.times, values)
        before, after = keys.at < self.times[0] - _SAME_FRAME, keys.at > self.times[-1] + _SAME_FRAME
        left, right = keys.frozen().where(before), keys.frozen().where(after)
        parts = [own]
        if len(left.at):
            parts = [left, *_bridge(curve, keys, left, left.at[-1], self.times[0]), *parts]
        if len(right.at):
            parts += [*_bridge(curve, keys, own, self.times[-1], right.at[0]), right]
        CurveKeys.joined(parts).replace_in(curve)


def _bridge(
    curve: bpy.types.FCurve, keys: CurveKeys, last: CurveKeys, start: float, end: float
) -> list[CurveKeys]:
    """Return keys that preserve a curve between two frames after its ``keys`` beyond them are removed.

    last: keys that end at start; the interpolation of the final one is set.
    """
    crossing = np.flatnonzero(keys.at <= start + _SAME_FRAME)
    kind = keys.values["interpolation"][crossing[-1]] if len(crossing) else None
    if kind in (choice("interpolation", "LINEAR"), choice("interpolation", "CONSTANT")):
        last.values["interpolation"][-1] = kind
        return []
    last.values["interpolation"][-1] = choice("interpolation", "LINEAR")
    times = np.arange(np.floor(start) + 1, np.ceil(end))
    return [CurveKeys.linear(times, np.array([curve.evaluate(time) for time in times]))]
