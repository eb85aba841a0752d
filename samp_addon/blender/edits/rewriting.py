"""A copy of an Action whose end is another motion; the keys before that stay exactly as they are."""

from __future__ import annotations

import bpy
import numpy as np

from ...motion import Motion
from .. import compat
from ..actions import keyframes
from ..actions.curve_keys import CurveKeys
from ..character.armature import calibrate

_SAME_FRAME = 1e-3  # frames: keys nearer than this count as one


def continued(
    owner: bpy.types.Object, action: bpy.types.Action, frame: int, tail: Motion, name: str
) -> bpy.types.Action:
    """Return a copy of an Action that goes on with another motion after a frame.

    tail: in the owner's proportions, at the scene's rate; its first frame is what the Action shows in ``frame``, and
    is not written. Curves of nothing that a motion moves keep their keys. The copy is not made active.
    """
    writer = compat.CurveWriter.on_copy(action, owner)
    try:
        writer.action.name, writer.action.use_fake_user = name, True
        for channel in keyframes.motion_channels(owner, calibrate(owner), tail):
            path = f'pose.bones["{bpy.utils.escape_identifier(channel.bone)}"].{channel.path}'
            curves = [writer.find(path, k) for k in range(channel.values.shape[1])]
            values = _nearest(channel.path, curves, channel.values, frame)
            for k, curve in enumerate(curves):
                if len(values) == 1 and (curve is None or len(curve.keyframe_points) == 1):
                    continue  # still before and after
                column = np.broadcast_to(values[:, k], (len(tail),))
                if curve is None:
                    curve = writer.add(path, k, np.array([frame]), column[:1], channel.bone)  # noqa: PLW2901
                _append(curve, frame, column[1:])
    except BaseException:
        bpy.data.actions.remove(writer.action)
        raise
    return writer.action


def _append(curve: bpy.types.FCurve, frame: int, values: np.ndarray) -> None:
    """Replace all keys after a frame by one on each frame with these values (n,)."""
    keys = CurveKeys.of(curve)
    kept = keys.frozen().where(keys.at < frame + _SAME_FRAME)
    between = np.arange(np.floor(kept.at[-1]) + 1 if len(kept.at) else frame, frame + 1)
    # Where the last keys lie farther apart than a frame, the curve is kept by a key on each one.
    held = CurveKeys.linear(between, np.array([curve.evaluate(time) for time in between]))
    if len(between) and len(kept.at):
        kept.values["interpolation"][-1] = held.values["interpolation"][0]
    own = CurveKeys.linear(np.arange(frame + 1, frame + 1 + len(values)), values)
    CurveKeys.joined([kept, held, own]).replace_in(curve)


def _nearest(path: str, curves: list[bpy.types.FCurve | None], values: np.ndarray, frame: int) -> np.ndarray:
    """Return values (T, n) of a rotation that go on from the curves without a jump of a whole turn or of the sign."""
    if any(curve is None for curve in curves) or not path.startswith("rotation"):
        return values
    now = np.array([curve.evaluate(frame) for curve in curves])
    if path == "rotation_quaternion":
        return values if now @ values[0] >= 0 else -values
    if path == "rotation_euler":
        return values + 2 * np.pi * np.round((now - values[0]) / (2 * np.pi))
    return values
