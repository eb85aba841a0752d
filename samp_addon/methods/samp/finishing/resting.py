"""Clearance of limbs from the object that a body rests on: pillows, mattresses, armrests, backs of sofas.

No motion was captured on a mattress or in an armchair. A limb that the rollout puts inside one is turned about its
upper joint until it is out: upwards onto the top or, where that is shorter, sideways.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import (
    distance_transform_edt,
    gaussian_filter1d,
    maximum_filter,
    minimum_filter,
)

from .... import rotation, skeleton
from ....easing import anticipate
from ....motion import Goal, Motion
from ....refine.feet.foot import sole_points, toe_tips
from ....refine.inverse_kinematics import at_height, solve_limb
from ....scene.seats.postures import BED_TO_PELVIS, SEAT_TO_PELVIS, to_pelvis
from ....scene.seats.reclining import CROWN, back_angle

CELL = 0.03  # metres
LEVEL = 0.04  # metres between the heights at which ways out of walls are known
HEADROOM = 0.55  # metres over the seat or mattress, above which the object is ignored
# Upper joint, lower joint, metres from the lower joint to the skin that it lies on; from the trunk outwards.
ARMS = (("shoulder", "elbow", 0.04), ("elbow", "wrist", 0.035), ("wrist", "middle2", 0.02))
BONES = {
    "sit": ARMS,
    "lie": (("spine1", "spine3", 0.10), ("spine3", "head", 0.10), ("hip", "knee", 0.065), ("knee", "ankle", 0.065),
            *ARMS),
}  # fmt: skip
TOPS = {
    "sit": (-0.05, 0.30),
    "lie": (-0.12, 0.22),
}  # metres, relative to the seat or mattress, of heights that limbs can lie on
MAX_LIFT = 0.16  # metres by which a joint is raised; one twice as deep is off the object, not in it
MAX_ASIDE = 0.28  # metres by which a joint is moved sideways
WALL = 0.05  # metres over the seat or mattress above which a height is a wall
BELOW = 0.15  # metres under the seat or mattress down to which a joint can be in a wall
WINDOW, SIGMA = 9, 4.0  # frames over which corrections begin early, and are smoothed
SOLE = 0.01  # metres between a sole and a wall
UPRIGHT = 0.15  # metres over the seated pelvis above which a body stands
HIGH_SEAT = 0.56  # metres over the floor of a seat from which the feet hang
SHIN_STEP = 0.06  # share of a shin between two samples
SHIN = 0.05  # metres from the middle of a shin to its skin
MAX_KEEP_OFF = 0.3  # metres by which a body is moved away from the side of the object
GIVE = 0.005  # metres that flesh and cushion yield under the pelvis
UNSURE = 0.03  # metres of correction at which half of a bone's horizontal direction is smoothed
REACH = 1.3  # horizontal metres around the goal within which limbs are corrected


@dataclass(frozen=True)
class RestingTop:
    """Height map of an object that a body rests on; metres over the floor.

    heights: (X, Z), minus infinity outside of the object. corner: (2,) x and z. level: of the seat or mattress. low,
    high: bounds of the heights that limbs can lie on. action: "sit" or "lie". back: angle of a raised back to lie on,
    radians; 0 where the body lies flat.
    """

    heights: np.ndarray
    corner: np.ndarray
    level: float
    low: float
    high: float
    action: str
    back: float = 0.0

    @classmethod
    def of(cls, points: np.ndarray, goal: Goal, floor: float) -> RestingTop:
        """Map the object with points (N, 3) on its surface, for a goal on it and a floor at this height."""
        lift = SEAT_TO_PELVIS if goal.action == "sit" else BED_TO_PELVIS
        level = float(goal.position[1]) - lift - floor
        corner = points[:, [0, 2]].min(0)
        shape = np.ceil(np.ptp(points[:, [0, 2]], axis=0) / CELL).astype(int) + 1
        back = back_angle(points, goal, level + floor) if goal.action == "lie" else 0.0
        points = points[points[:, 1] - floor < level + (CROWN if back else HEADROOM)]
        cells = np.ravel_multi_index(tuple(((points[:, [0, 2]] - corner) / CELL).astype(int).T), shape)
        top = np.full(int(np.prod(shape)), -np.inf)
        np.maximum.at(top, cells, points[:, 1] - floor)
        top = top.reshape(shape)
        # Now and then the samples of a cell miss its top and hit only its bottom.
        top = minimum_filter(maximum_filter(np.pad(top, 1, constant_values=-np.inf), 3), 3)[1:-1, 1:-1]
        below, above = TOPS[goal.action]
        above = CROWN if back else above
        return cls(top, corner, level, level + below, level + above, goal.action, back)

    def cells(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the cell indices x and z of places (T, 2), and flags of those on the grid."""
        at = np.floor((places - self.corner) / CELL).astype(int)
        inside = ((at >= 0) & (at < self.heights.shape)).all(-1)
        x, z = np.clip(at, 0, np.array(self.heights.shape) - 1).T
        return x, z, inside

    def missing(self, joint: np.ndarray, thick: float | np.ndarray) -> np.ndarray:
        """Return the metres (T,) by which a joint (T, 3) is too low to lie on the top; 0 where there is no top below.

        thick: metres from the joint to its skin, one number or (T,).
        """
        x, z, inside = self.cells(joint[:, [0, 2]])
        found = self.heights[x, z]
        on = inside & (found > self.low) & (found < self.high)
        return np.where(on, np.maximum(found + thick - joint[:, 1], 0.0), 0.0)

    @cached_property
    def _ways_out(self) -> np.ndarray:
        """Return the nearest cells (K, 2, X, Z) below each of K levels, LEVEL apart, from WALL over the seat up."""
        levels = self.level + np.arange(WALL, HEADROOM, LEVEL)
        return np.array([_nearest_free(self.heights > level) for level in levels])

    def aside(self, joint: np.ndarray, thick: float) -> np.ndarray:
        """Return the horizontal offset (T, 2) that moves a joint (T, 3) out of the wall that it is in."""
        x, z, inside = self.cells(joint[:, [0, 2]])
        height = joint[:, 1] - thick - self.level
        step = np.clip(np.floor((height - WALL) / LEVEL).astype(int), 0, len(self._ways_out) - 1)
        wall = self.heights[x, z] - self.level > np.maximum(height, WALL)
        nearest = self._ways_out[step, :, x, z]
        offset = self.corner + (nearest + 0.5) * CELL - joint[:, [0, 2]]
        length = np.linalg.norm(offset, axis=-1, keepdims=True)
        offset *= 1 + thick / np.maximum(length, CELL)
        return np.where(
            (inside & wall & (height > -BELOW) & (length[:, 0] < MAX_ASIDE))[:, None], offset, 0.0
        )

    def cleared(self, motion: Motion, goal: np.ndarray) -> Motion:
        """Return the motion with its limbs out of the object. goal: row of Route.goals. The floor is at height 0."""
        near = np.linalg.norm(motion.root[:, [0, 2]] - goal[[0, 2]], axis=-1) < REACH
        if self.action == "lie":
            motion = self._raise_pelvis(self._keep_off(motion, near), near)
        else:
            motion = self._keep_off(motion, near & self._stands(motion))
        for upper, lower, thick in BONES[self.action]:
            sideways = upper not in skeleton.INDEX  # bones of the trunk have no side, and are only raised
            for side in ("right_", "left_") if sideways else ("",):
                motion = self._clear_bone(motion, side + upper, side + lower, thick, near, sideways)
        return self._clear_feet(motion, near) if self.action == "lie" else motion

    def _stands(self, motion: Motion) -> np.ndarray:
        """Return flags (T,) of bodies in front of the seat, which are moved out of it; sinking ones may be inside."""
        upright = motion.root[:, 1] > self.level + SEAT_TO_PELVIS + UPRIGHT
        if self.level > HIGH_SEAT and motion.interaction_start is not None:
            # The pelvis hardly sinks onto a high seat.
            upright |= np.arange(len(motion)) < motion.interaction_start
        return upright

    def _clear_feet(self, motion: Motion, near: np.ndarray) -> Motion:
        """Bend the knees as far as soles would otherwise be in an armrest or a footboard. near: (T,) flags."""
        for side in ("right", "left"):
            positions, globals_ = motion.forward_kinematics()
            rest = motion.rest_joints
            knee = positions[:, skeleton.INDEX[f"{side}_knee"]]
            soles = (*sole_points(positions, globals_, rest, side), toe_tips(positions, globals_, rest, side))
            away = np.zeros((len(motion), 2))
            for sole in soles:
                offset = self._short_of_wall(knee, sole)
                more = near & (np.linalg.norm(offset, axis=-1) > np.linalg.norm(away, axis=-1))
                away[more] = offset[more]
            if not away.any():
                continue
            away = gaussian_filter1d(away, SIGMA, axis=0, mode="nearest")
            target = positions[:, skeleton.INDEX[f"{side}_ankle"]] + np.column_stack(
                [away[:, 0], np.zeros(len(away)), away[:, 1]]
            )
            rotations = solve_limb(motion.root, motion.rotations, rest, f"{side}_leg", target)
            motion = replace(motion, rotations=rotations)
        return motion

    def _keep_off(self, motion: Motion, near: np.ndarray) -> Motion:
        """Move the body so far off the object that shins below its top are not inside. near: (T,) flags."""
        positions, _ = motion.forward_kinematics()
        out = np.zeros((len(motion), 2))
        for side in ("right", "left"):
            knee, ankle = (positions[:, skeleton.INDEX[f"{side}_{name}"]] for name in ("knee", "ankle"))
            for share in (0.0, 0.5, 1.0):
                point = ankle + share * (knee - ankle)
                offset = self._off_the_side(point)
                more = np.linalg.norm(offset, axis=-1) > np.linalg.norm(out, axis=-1)
                out[more & near] = offset[more & near]
        if not out.any():
            return motion
        distance = np.linalg.norm(out, axis=-1)
        # One direction for all frames, so that bodies do not weave.
        mean = (out * distance[:, None]).sum(0)
        mean /= max(float(np.linalg.norm(mean)), 1e-9)
        far = np.maximum(out @ mean, 0.0)
        far = anticipate(far, 2 * WINDOW, 1.5 * SIGMA)
        return replace(motion, root=motion.root + far[:, None] * np.array([mean[0], 0.0, mean[1]]))

    def _off_the_side(self, point: np.ndarray) -> np.ndarray:
        """Return the horizontal offset (T, 2) that moves points (T, 3) below the top out over its nearest edge."""
        x, z, inside = self.cells(point[:, [0, 2]])
        below = inside & (point[:, 1] < self.level - MAX_LIFT) & (self.heights[x, z] > self.low)
        nearest = self._nearest_outside[:, x, z].T
        offset = self.corner + (nearest + 0.5) * CELL - point[:, [0, 2]]
        length = np.linalg.norm(offset, axis=-1, keepdims=True)
        offset *= np.minimum(length + SHIN, MAX_KEEP_OFF) / np.maximum(length, 1e-6)
        return np.where(below[:, None], offset, 0.0)

    def _short_of_wall(self, knee: np.ndarray, sole: np.ndarray) -> np.ndarray:
        """Return the horizontal offset (T, 2) that brings a sole (T, 3) back to its knee's side of a wall."""
        shin = (sole - knee)[:, [0, 2]]
        out = np.zeros((len(sole), 2))
        for share in np.arange(1.0, 0.0, -SHIN_STEP):
            place = knee[:, [0, 2]] + share * shin
            x, z, inside = self.cells(place)
            height = sole[:, 1] - SOLE - self.level
            wall = inside & (self.heights[x, z] - self.level > np.maximum(height, WALL)) & (height > -BELOW)
            out[wall] = (share - SHIN_STEP - 1.0) * shin[wall]
        short = np.linalg.norm(out, axis=-1, keepdims=True) < MAX_ASIDE
        return np.where(short, out, 0.0)

    @cached_property
    def _nearest_outside(self) -> np.ndarray:
        """Return the nearest cells (2, X, Z) outside of the object."""
        return _nearest_free(self.heights > self.low)

    def _raise_pelvis(self, motion: Motion, near: np.ndarray) -> Motion:
        """Raise a pelvis that sits on the edge, or lies, lower than buttocks or back allow. near: (T,) flags."""
        _, globals_ = motion.forward_kinematics()
        thick = to_pelvis(rotation.uprightness(globals_[:, skeleton.INDEX["spine1"]])) - GIVE
        missing = np.where(near, _lift_in_reach(self.missing(motion.root, thick)), 0.0)
        if not missing.any():
            return motion
        lift = anticipate(missing, WINDOW, SIGMA)
        return replace(motion, root=motion.root + lift[:, None] * np.array([0.0, 1.0, 0.0]))

    def _clear_bone(
        self, motion: Motion, upper: str, lower: str, thick: float, near: np.ndarray, sideways: bool
    ) -> Motion:
        """Turn the bone between two joints out of the object, upwards or, where allowed, sideways. near: (T,) flags."""
        joint = bone_end(motion, upper, lower)
        missing = np.where(near, self.missing(joint, thick), 0.0)
        up = _lift_in_reach(missing)
        away = np.zeros((len(motion), 2))
        if sideways:
            away = np.where(near[:, None], self.aside(joint, thick), 0.0)
            # Shallow limbs are raised onto the mattress, even near its edge; walls are left by the shorter way.
            distance = np.linalg.norm(away, axis=-1)
            rather_up = (missing > 0) & (missing < np.maximum(distance, 0.5 * MAX_LIFT))
            up, away = np.where(rather_up | (distance == 0), up, 0.0), np.where(rather_up[:, None], 0.0, away)
        if not (up.any() or away.any()):
            return motion
        up = anticipate(up, WINDOW, SIGMA)
        return turned_bone(motion, upper, joint, np.column_stack([away[:, 0], up, away[:, 1]]))


def _nearest_free(solid: np.ndarray) -> np.ndarray:
    """Return the nearest free cell (2, X, Z) of each cell of a grid (X, Z); outside the grid all is free."""
    found = distance_transform_edt(np.pad(solid, 1), return_distances=False, return_indices=True)
    return found[:, 1:-1, 1:-1] - 1


def _lift_in_reach(missing: np.ndarray) -> np.ndarray:
    """Return the lifts (T,) of joints too low by ``missing`` (T,): one that is much too low is off the object."""
    return np.maximum(np.minimum(missing, 2 * MAX_LIFT - missing), 0.0)


def bone_end(motion: Motion, upper: str, lower: str) -> np.ndarray:
    """Return the world position (T, 3) of a bone's lower joint; fingers are as straight as in the rest pose."""
    positions, globals_ = motion.forward_kinematics()
    a, b = skeleton.INDEX[upper], skeleton.INDEX[lower]
    if b < positions.shape[1]:
        return positions[:, b]
    rest = skeleton.default_rest_joints()
    return positions[:, a] + rotation.rotate(
        globals_[:, a], np.broadcast_to(rest[b] - rest[a], (len(motion), 3))
    )


def turned_bone(motion: Motion, upper: str, end: np.ndarray, offset: np.ndarray) -> Motion:
    """Turn a joint so that a point (T, 3) on its bone moves by an offset (T, 3), metres.

    The horizontal part of the offset is smoothed over SIGMA frames.
    """
    a = skeleton.INDEX[upper]
    positions, globals_ = motion.forward_kinematics()
    offset = offset.copy()
    offset[:, [0, 2]] = gaussian_filter1d(offset[:, [0, 2]], SIGMA, axis=0, mode="nearest")
    bone = end - positions[:, a]
    length = np.linalg.norm(bone, axis=-1)
    # The height is reached as far as the bone's length allows; upright bones stay upright.
    most = np.maximum(0.98 * length, np.abs(bone[:, 1]))
    rise = np.clip(bone[:, 1] + offset[:, 1], -most, most)
    flat = (bone + offset)[:, [0, 2]]
    # The horizontal direction of upright bones is arbitrary; it is taken from the frames before and after.
    length = np.linalg.norm(offset, axis=-1)
    share = (length / (length + UNSURE))[:, None]
    flat = flat + share * (gaussian_filter1d(flat, 1.5 * SIGMA, axis=0, mode="nearest") - flat)
    turn = rotation.between(bone, at_height(bone, rise, flat))
    parent = globals_[:, skeleton.PARENTS[a]]
    rotations = motion.rotations.copy()
    rotations[:, a] = rotation.multiply(rotation.conjugate(parent), rotation.multiply(turn, globals_[:, a]))
    return replace(motion, rotations=rotations)
