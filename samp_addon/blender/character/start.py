"""Where a character's takes start: stored with the armature object, so that they do not depend on the playhead.

The place is relative to the armature object: moving the character moves its start too.
"""

from __future__ import annotations

import bpy
import numpy as np

from ... import frames
from ..actions import keyframes, notes
from . import armature

START_KEY = "samp_start"
"""Custom property of an armature: position (3) and facing (3) in the object's own axes."""

Place = tuple[np.ndarray, float]
"""Floor position (3,) and yaw in radians, network frame."""


def store(owner: bpy.types.Object, place: Place) -> None:
    """Store a start with the armature."""
    inverse = np.linalg.inv(np.array(owner.matrix_world, dtype=np.float64))
    position = inverse @ np.append(frames.to_blender(place[0]), 1.0)
    direction = inverse[:3, :3] @ frames.to_blender(frames.yaw_direction(place[1]))
    direction /= max(np.linalg.norm(direction), 1e-12)
    owner[START_KEY] = [*map(float, position[:3]), *map(float, direction)]


def stored(owner: bpy.types.Object) -> Place | None:
    """Return the start that is stored with the armature, or None."""
    numbers = owner.get(START_KEY)
    if numbers is None or len(numbers) != 6:
        return None
    world = np.array(owner.matrix_world, dtype=np.float64)
    position = world @ np.append(np.array(numbers[:3], dtype=np.float64), 1.0)
    direction = frames.to_network(world[:3, :3] @ np.array(numbers[3:], dtype=np.float64))
    return frames.to_network(position[:3]), float(frames.direction_yaw(direction))


def first_start(owner: bpy.types.Object) -> Place:
    """Return a start for an armature without one: where its active take begins, else where it stands now."""
    data = owner.animation_data
    action = data.action if data is not None else None
    if not notes.is_take(action):
        return armature.standing_floor(owner)
    first = int(np.floor(action.frame_range[0]))
    motion = keyframes.read_motion(owner, action, first, first)
    floor = motion.root[0] + [0.0, armature.calibrate(owner).rest_joints[:, 1].min(), 0.0]
    return floor, float(frames.direction_yaw(motion.headings()[0]))
