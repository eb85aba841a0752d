"""Limbs on what a body rests on, and beside what it leans against, not in it: pillows, armrests, backs of sofas.

Nobody was captured on a mattress or in an armchair. A limb that the rollout puts inside one is turned about its upper
joint until it is out: upwards onto the top, or, where that is nearer, aside.
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
from ....easing import anticipate, smoothstep
from ....motion import Goal, Motion
from ....refine.feet.foot import sole_points, toe_tips
from ....refine.inverse_kinematics import at_height, solve_limb
from ....scene.seats.postures import BED_TO_PELVIS, SEAT_TO_PELVIS

CELL = 0.03
LEVEL = 0.04  # metres of height between two looks for a way aside
HEADROOM = 0.55  # metres over the seat or mattress; what is higher is not touched
# Upper joint, lower joint, metres from the lower joint to the skin that it lies on: from the trunk outwards.
ARMS = (("shoulder", "elbow", 0.04), ("elbow", "wrist", 0.035), ("wrist", "middle2", 0.02))
BONES = {
    "sit": ARMS,
    "lie": (("spine1", "spine3", 0.10), ("spine3", "head", 0.10), ("hip", "knee", 0.065), ("knee", "ankle", 0.065),
            *ARMS),
}  # fmt: skip
TOPS = {"sit": (-0.05, 0.30), "lie": (-0.12, 0.22)}  # metres about the seat or mattress that count as its top
MOST = 0.16  # metres by which a joint is raised; twice as deep it is beside the piece, not in it
MOST_ASIDE = 0.28
WALL = 0.05  # metres over the seat or mattress from which on things are left aside
BELOW = 0.15  # metres under it down to which a joint may be in a wall
SOONER, EVENLY = 9, 4.0  # frames: window and standard deviation over which limbs give way
SOLE = 0.01  # metres that a sole keeps off a wall
UPRIGHT = 0.15  # metres over the seated pelvis from which somebody stands
SHIN_STEP = 0.06  # of a shin, between two looks for a wall
SHIN = 0.05  # metres from the middle of a shin to its skin
MOST_BESIDE = 0.3  # metres by which a body keeps off
GIVE = 0.005  # metres that flesh and cushion give way under the pelvis
UNSURE = 0.03  # metres moved at which half of a bone's direction over the floor is its own
REACH = 1.3  # metres on the floor around the goal in which limbs are looked after


@dataclass(frozen=True)
class RestingTop:
    """Heights (X, Z) of a piece over the floor, minus infinity where it is not; corner (2,): x and z.

    level: of the seat or mattress. low, high: between these the heights are a top that limbs may lie on.
    """

    heights: np.ndarray
    corner: np.ndarray
    level: float
    low: float
    high: float
    action: str

    @classmethod
    def of(cls, points: np.ndarray, goal: Goal, floor: float) -> RestingTop:
        """The top of a piece, told by points (N, 3) on its surface, about a goal, over a floor at this height."""
        lift = SEAT_TO_PELVIS if goal.action == "sit" else BED_TO_PELVIS
        level = float(goal.position[1]) - lift - floor
        corner = points[:, [0, 2]].min(0)
        shape = np.ceil(np.ptp(points[:, [0, 2]], axis=0) / CELL).astype(int) + 1
        points = points[points[:, 1] - floor < level + HEADROOM]
        cells = np.ravel_multi_index(tuple(((points[:, [0, 2]] - corner) / CELL).astype(int).T), shape)
        top = np.full(int(np.prod(shape)), -np.inf)
        np.maximum.at(top, cells, points[:, 1] - floor)
        top = top.reshape(shape)
        # Samples miss a cell of the top now and then and hit only its bottom.
        top = minimum_filter(maximum_filter(np.pad(top, 1, constant_values=-np.inf), 3), 3)[1:-1, 1:-1]
        below, above = TOPS[goal.action]
        return cls(top, corner, level, level + below, level + above, goal.action)

    def _cells(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Cell indices of places (T, 2), and which are on the grid."""
        at = np.floor((places - self.corner) / CELL).astype(int)
        inside = ((at >= 0) & (at < self.heights.shape)).all(-1)
        x, z = np.clip(at, 0, np.array(self.heights.shape) - 1).T
        return x, z, inside

    def missing(self, joint: np.ndarray, thick: float | np.ndarray) -> np.ndarray:
        """Metres (T,) by which a joint (T, 3) is too low to lie on the top; 0 where that is not below it.

        thick: metres from the joint to its skin, one number or (T,).
        """
        x, z, inside = self._cells(joint[:, [0, 2]])
        found = self.heights[x, z]
        on = inside & (found > self.low) & (found < self.high)
        return np.where(on, np.maximum(found + thick - joint[:, 1], 0.0), 0.0)

    @cached_property
    def _ways_out(self) -> np.ndarray:
        """For heights LEVEL apart from WALL over the seat up: the nearest cell (K, 2, X, Z) that is not higher."""
        levels = self.level + np.arange(WALL, HEADROOM, LEVEL)
        return np.array([_nearest_free(self.heights > level) for level in levels])

    def aside(self, joint: np.ndarray, thick: float) -> np.ndarray:
        """Way (T, 2) over the floor, metres, by which a joint (T, 3) comes out of a wall that it is in."""
        x, z, inside = self._cells(joint[:, [0, 2]])
        height = joint[:, 1] - thick - self.level
        step = np.clip(np.floor((height - WALL) / LEVEL).astype(int), 0, len(self._ways_out) - 1)
        wall = self.heights[x, z] - self.level > np.maximum(height, WALL)
        nearest = self._ways_out[step, :, x, z]
        way = self.corner + (nearest + 0.5) * CELL - joint[:, [0, 2]]
        length = np.linalg.norm(way, axis=-1, keepdims=True)
        way *= 1 + thick / np.maximum(length, CELL)
        return np.where((inside & wall & (height > -BELOW) & (length[:, 0] < MOST_ASIDE))[:, None], way, 0.0)

    def cleared(self, motion: Motion, goal: np.ndarray) -> Motion:
        """The motion, over a floor at height 0, with its limbs out of the piece. goal: row of Route.goals."""
        near = np.linalg.norm(motion.root[:, [0, 2]] - goal[[0, 2]], axis=-1) < REACH
        if self.action == "lie":
            motion = self._on_top(self._beside(motion, near), near)
        else:
            # Who turns in front of a seat does not stand in it; who sinks onto it may.
            motion = self._beside(motion, near & (motion.root[:, 1] > self.level + SEAT_TO_PELVIS + UPRIGHT))
        for upper, lower, thick in BONES[self.action]:
            sideways = upper not in skeleton.INDEX  # the trunk's bones have no sides and stay in their middle
            for side in ("right_", "left_") if sideways else ("",):
                motion = self._out(motion, side + upper, side + lower, thick, near, sideways)
        return self._feet_out(motion, near) if self.action == "lie" else motion

    def _feet_out(self, motion: Motion, near: np.ndarray) -> Motion:
        """The motion whose knees bend as far as soles would else be in an armrest or a board at the foot."""
        for side in ("right", "left"):
            positions, globals_ = motion.forward_kinematics()
            rest = motion.rest_joints
            knee = positions[:, skeleton.INDEX[f"{side}_knee"]]
            soles = (*sole_points(positions, globals_, rest, side), toe_tips(positions, globals_, rest, side))
            away = np.zeros((len(motion), 2))
            for sole in soles:
                way = self._short_of_wall(knee, sole)
                more = near & (np.linalg.norm(way, axis=-1) > np.linalg.norm(away, axis=-1))
                away[more] = way[more]
            if not away.any():
                continue
            away = gaussian_filter1d(away, EVENLY, axis=0, mode="nearest")
            target = positions[:, skeleton.INDEX[f"{side}_ankle"]] + np.column_stack(
                [away[:, 0], np.zeros(len(away)), away[:, 1]]
            )
            rotations = solve_limb(motion.root, motion.rotations, rest, f"{side}_leg", target)
            motion = replace(motion, rotations=rotations)
        return motion

    def _beside(self, motion: Motion, near: np.ndarray) -> Motion:
        """The motion whose body keeps so far off a bed that shins below its top are not in it."""
        positions, _ = motion.forward_kinematics()
        out = np.zeros((len(motion), 2))
        for side in ("right", "left"):
            knee, ankle = (positions[:, skeleton.INDEX[f"{side}_{name}"]] for name in ("knee", "ankle"))
            for share in (0.0, 0.5, 1.0):
                point = ankle + share * (knee - ankle)
                way = self._out_of_the_side(point)
                more = np.linalg.norm(way, axis=-1) > np.linalg.norm(out, axis=-1)
                out[more & near] = way[more & near]
        if not out.any():
            return motion
        distance = np.linalg.norm(out, axis=-1)
        # The same way all along, so that bodies do not weave.
        mean = (out * distance[:, None]).sum(0)
        mean /= max(float(np.linalg.norm(mean)), 1e-9)
        far = np.maximum(out @ mean, 0.0)
        far = anticipate(far, 2 * SOONER, 1.5 * EVENLY)
        return replace(motion, root=motion.root + far[:, None] * np.array([mean[0], 0.0, mean[1]]))

    def _out_of_the_side(self, point: np.ndarray) -> np.ndarray:
        """Way (T, 2) over the floor by which points (T, 3) below the top come out over its nearest edge."""
        x, z, inside = self._cells(point[:, [0, 2]])
        below = inside & (point[:, 1] < self.level - MOST) & (self.heights[x, z] > self.low)
        nearest = self._ways_beside[:, x, z].T
        way = self.corner + (nearest + 0.5) * CELL - point[:, [0, 2]]
        length = np.linalg.norm(way, axis=-1, keepdims=True)
        way *= np.minimum(length + SHIN, MOST_BESIDE) / np.maximum(length, 1e-6)
        return np.where(below[:, None], way, 0.0)

    def _short_of_wall(self, knee: np.ndarray, sole: np.ndarray) -> np.ndarray:
        """Way (T, 2) over the floor, metres, by which a sole (T, 3) comes back to its knee's side of a wall."""
        shin = (sole - knee)[:, [0, 2]]
        out = np.zeros((len(sole), 2))
        for share in np.arange(1.0, 0.0, -SHIN_STEP):
            place = knee[:, [0, 2]] + share * shin
            x, z, inside = self._cells(place)
            height = sole[:, 1] - SOLE - self.level
            wall = inside & (self.heights[x, z] - self.level > np.maximum(height, WALL)) & (height > -BELOW)
            out[wall] = (share - SHIN_STEP - 1.0) * shin[wall]
        short = np.linalg.norm(out, axis=-1, keepdims=True) < MOST_ASIDE
        return np.where(short, out, 0.0)

    @cached_property
    def _ways_beside(self) -> np.ndarray:
        """The nearest cell (2, X, Z) that is not on the piece."""
        return _nearest_free(self.heights > self.low)

    def _on_top(self, motion: Motion, near: np.ndarray) -> Motion:
        """The motion whose pelvis, sitting on the edge or lying, is not lower than buttocks or back allow."""
        _, globals_ = motion.forward_kinematics()
        upright = rotation.quaternion_to_matrix(globals_[:, skeleton.INDEX["spine1"]])[:, 1, 1]
        thick = BED_TO_PELVIS + (SEAT_TO_PELVIS - BED_TO_PELVIS) * smoothstep(upright) - GIVE
        missing = np.where(near, _within_reason(self.missing(motion.root, thick)), 0.0)
        if not missing.any():
            return motion
        lift = anticipate(missing, SOONER, EVENLY)
        return replace(motion, root=motion.root + lift[:, None] * np.array([0.0, 1.0, 0.0]))

    def _out(
        self, motion: Motion, upper: str, lower: str, thick: float, near: np.ndarray, sideways: bool
    ) -> Motion:
        joint = _end(motion, upper, lower)
        missing = np.where(near, self.missing(joint, thick), 0.0)
        up = _within_reason(missing)
        away = np.zeros((len(motion), 2))
        if sideways:
            away = np.where(near[:, None], self.aside(joint, thick), 0.0)
            # A little is raised onto the mattress, even beside its edge; a wall is left by the shorter way.
            distance = np.linalg.norm(away, axis=-1)
            rather_up = (missing > 0) & (missing < np.maximum(distance, 0.5 * MOST))
            up, away = np.where(rather_up | (distance == 0), up, 0.0), np.where(rather_up[:, None], 0.0, away)
        if not (up.any() or away.any()):
            return motion
        up = anticipate(up, SOONER, EVENLY)
        return turned(motion, upper, joint, np.column_stack([away[:, 0], up, away[:, 1]]), EVENLY)


def _nearest_free(solid: np.ndarray) -> np.ndarray:
    """For each cell of a grid (X, Z) the nearest one (2, X, Z) that is not solid; all around the grid is free."""
    found = distance_transform_edt(np.pad(solid, 1), return_distances=False, return_indices=True)
    return found[:, 1:-1, 1:-1] - 1


def _within_reason(missing: np.ndarray) -> np.ndarray:
    """Heights (T,) by which joints are raised that are so much too low: what is much too low is beside the piece."""
    return np.maximum(np.minimum(missing, 2 * MOST - missing), 0.0)


def _end(motion: Motion, upper: str, lower: str) -> np.ndarray:
    """World place (T, 3) of a bone's lower joint; fingers are as straight as in the rest pose."""
    positions, globals_ = motion.forward_kinematics()
    a, b = skeleton.INDEX[upper], skeleton.INDEX[lower]
    if b < positions.shape[1]:
        return positions[:, b]
    rest = skeleton.default_rest_joints()
    return positions[:, a] + rotation.rotate(
        globals_[:, a], np.broadcast_to(rest[b] - rest[a], (len(motion), 3))
    )


def turned(motion: Motion, upper: str, end: np.ndarray, way: np.ndarray, evenly: float) -> Motion:
    """The motion with a joint turned so that a place (T, 3) on its bone goes some way (T, 3), metres.

    evenly: frames, standard deviation over which the way over the floor is smoothed.
    """
    a = skeleton.INDEX[upper]
    positions, globals_ = motion.forward_kinematics()
    way = way.copy()
    way[:, [0, 2]] = gaussian_filter1d(way[:, [0, 2]], evenly, axis=0, mode="nearest")
    bone = end - positions[:, a]
    length = np.linalg.norm(bone, axis=-1)
    # The height is reached exactly as far as the bone's length allows; one that is upright already stays.
    most = np.maximum(0.98 * length, np.abs(bone[:, 1]))
    rise = np.clip(bone[:, 1] + way[:, 1], -most, most)
    flat = (bone + way)[:, [0, 2]]
    # Bones that hang or stand have no direction over the floor of their own; theirs comes from before and after.
    share = (np.linalg.norm(way, axis=-1) / (np.linalg.norm(way, axis=-1) + UNSURE))[:, None]
    flat = flat + share * (gaussian_filter1d(flat, 1.5 * evenly, axis=0, mode="nearest") - flat)
    about = rotation.between(bone, at_height(bone, rise, flat))
    parent = globals_[:, skeleton.PARENTS[a]]
    rotations = motion.rotations.copy()
    rotations[:, a] = rotation.multiply(rotation.conjugate(parent), rotation.multiply(about, globals_[:, a]))
    return replace(motion, rotations=rotations)
