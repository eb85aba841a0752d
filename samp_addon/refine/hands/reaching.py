"""Bring a palm to places with the whole arm and, where that does not reach, the trunk. Network frame, metres, radians.

Of all changes of the joints that bring the palm to its place, the smallest one is looked for, with a trunk that costs
more than an arm: so the arm moves first, and the trunk turns and leans where the arm is near full stretch. Each
iteration solves that problem linearised; its damping grows with the distance that is left (Sugihara 2011), so that a
place out of reach is approached without jitter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ... import rotation, skeleton
from ...body.joint_limits import limits
from ...motion import Motion
from .palm import DOWN, HandContact, offset, palm

ITERATIONS = 60

LARGEST_STEP = 0.25
"""Radians of a joint in one iteration."""

NEAR, STILL = 1e-3, 1e-3
"""Metres off its place at which a palm is there, and the change of a quaternion in one iteration that is none."""

BACK = 0.4
"""Share of the way back to the joints as they were that one iteration goes, where the palm allows it."""

DAMPING = 2e-5
FACING_SOFTNESS = 0.15
"""Against the palm's place, which is exact, its facing gives way."""

COSTS = {
    "spine1": (14.0, 14.0, 14.0),
    "spine2": (12.0, 12.0, 12.0),
    "spine3": (10.0, 10.0, 10.0),
    "collar": (5.0, 5.0, 5.0),
    "shoulder": (1.0, 1.0, 1.0),
    "elbow": (2.0, 0.7, 8.0),
    "wrist": (3.0, 2.5, 2.5),
}
"""Cost of a squared radian of each joint, about its own axes x, y, z; an elbow is a hinge about y, and twists about
x."""

FARTHEST = {"spine1": 50.0, "spine2": 40.0, "spine3": 30.0, "collar": 30.0, "wrist": 70.0}
"""Degrees from the zero pose that joints turn here at most: their limits are of bodies that bow and lie."""


@dataclass(frozen=True)
class Reached:
    """A motion with a hand on its places. missed: (T,) metres by which the palm is off; 0 where the hand is free."""

    motion: Motion
    missed: np.ndarray


def reach(motion: Motion, contact: HandContact) -> Reached:
    """Return a motion with a palm on its places where the contact's weight is 1, and on the way there in between.

    Only joints of trunk and arm turn, within their limits; frames with weight 0 stay exactly as they are.
    """
    used = np.flatnonzero(contact.weight > 0)
    missed = np.zeros(len(motion))
    if not len(used):
        return Reached(motion, missed)
    chain = _Chain.of(motion, contact.side, used)
    aims, facing = _aims(motion, contact, used)
    turned = chain.solved(aims, facing)
    rotations = motion.rotations.copy()
    rotations[np.ix_(used, chain.joints)] = turned
    made = replace(motion, rotations=rotations)
    middle, _ = palm(*made.forward_kinematics(), motion.rest_joints, contact.side)
    missed[used] = np.linalg.norm(middle[used] - aims, axis=-1)
    return Reached(replace(made, rotations=rotation.continuous(rotations)), missed)


def kept(motion: Motion, contacts: Sequence[HandContact]) -> Motion:
    """Return a motion with all its hands on their places, as far as they reach."""
    for contact in contacts:
        motion = reach(motion, contact).motion
    return motion


def _aims(motion: Motion, contact: HandContact, used: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Return where the palm is to be (N, 3) in the used frames, and what it is to face (N, 3), or None."""
    middle, normal = palm(*motion.forward_kinematics(), motion.rest_joints, contact.side)
    share = contact.weight[used, None]
    aims = middle[used] + share * (contact.places[used] - middle[used])
    if contact.facing is None:
        return aims, None
    turn = rotation.to_axis_angle(rotation.between(normal[used], contact.facing[used]))
    return aims, rotation.rotate(rotation.from_axis_angle(share * turn), normal[used])


@dataclass(frozen=True)
class _Chain:
    """Trunk and arm from spine1 to the wrist in N frames.

    joints: (7,) indices. local: (N, 7, 4) rotations as they were. base: (N, 4) and start: (N, 3) global rotation and
    place of the pelvis. bones: (7, 3) of each joint from the one above it. tip: (3,) the palm in the wrist's frame.
    free: (21,) inverse costs. allowed: (N, 7) largest angles.
    """

    joints: np.ndarray
    local: np.ndarray
    base: np.ndarray
    start: np.ndarray
    bones: np.ndarray
    tip: np.ndarray
    free: np.ndarray
    allowed: np.ndarray

    @classmethod
    def of(cls, motion: Motion, side: str, used: np.ndarray) -> _Chain:
        trunk, arm = ("spine1", "spine2", "spine3"), ("collar", "shoulder", "elbow", "wrist")
        joints = np.array([skeleton.INDEX[name] for name in (*trunk, *(f"{side}_{name}" for name in arm))])
        rest, local = motion.rest_joints, motion.rotations[used][:, joints]
        most = np.minimum(
            limits()[joints], np.radians([FARTHEST.get(name, 180.0) for name in (*trunk, *arm)])
        )
        now = np.linalg.norm(rotation.to_axis_angle(local), axis=-1)
        costs = np.array([COSTS[name] for name in (*trunk, *arm)])
        return cls(
            joints, local, motion.rotations[used, 0], motion.root[used], rest[joints] - rest[skeleton.PARENTS[joints]],
            offset(rest, side), 1 / costs.ravel(), np.maximum(most, now),
        )  # fmt: skip

    def solved(self, aims: np.ndarray, facing: np.ndarray | None) -> np.ndarray:
        """Return local rotations (N, 7, 4) with the palm at the aims (N, 3), facing (N, 3) if given."""
        local = self.local.copy()
        going = np.arange(len(aims))
        for _ in range(ITERATIONS):
            step, left = self._frames(going)._step(
                local[going], aims[going], None if facing is None else facing[going]
            )
            turned = rotation.multiply(local[going], rotation.from_axis_angle(step))
            within = self._frames(going)._within(turned)
            moved = np.abs(within - local[going]).max((1, 2))
            local[going] = within
            going = going[(moved > STILL) | (left > NEAR) & (moved > STILL / 10)]
            if not len(going):
                break
        return local

    def _frames(self, rows: np.ndarray) -> _Chain:
        """Return the chain in some frames."""
        own = {name: getattr(self, name)[rows] for name in ("local", "base", "start", "allowed")}
        return replace(self, **own)

    def _forward(self, local: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return places (N, 7, 3) and global rotations (N, 7, 4) of the joints, and the palm (N, 3)."""
        above, at = self.base, self.start
        places, globals_ = [], []
        for k in range(len(self.joints)):
            at = at + rotation.rotate(above, np.broadcast_to(self.bones[k], at.shape))
            above = rotation.multiply(above, local[:, k])
            places.append(at)
            globals_.append(above)
        tip = at + rotation.rotate(above, np.broadcast_to(self.tip, at.shape))
        return np.stack(places, 1), np.stack(globals_, 1), tip

    def _step(
        self, local: np.ndarray, aims: np.ndarray, facing: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return rotation vectors (N, 7, 3), the next step, and the distance (N,) of the palm from its aim."""
        places, globals_, tip = self._forward(local)
        axes = rotation.quaternion_to_matrix(globals_).swapaxes(
            -1, -2
        )  # rows: the joints' own axes in the world
        moved = np.cross(axes, (tip[:, None] - places)[:, :, None])
        rows, error = moved.reshape(len(tip), -1, 3).swapaxes(1, 2), aims - tip
        left = np.sum(error * error, -1, keepdims=True)
        soft, damping = np.full((len(tip), 3), DAMPING), np.repeat(DAMPING + 0.5 * left, 3, 1)
        if facing is not None:
            now = rotation.rotate(globals_[:, -1], np.broadcast_to(DOWN, facing.shape))
            across = np.eye(3) - now[:, :, None] * now[:, None]  # turning about the facing changes nothing
            rows = np.concatenate([rows, across @ axes.reshape(len(now), -1, 3).swapaxes(1, 2)], 1)
            error = np.concatenate([error, rotation.to_axis_angle(rotation.between(now, facing))], 1)
            more = np.full((len(now), 3), FACING_SOFTNESS)
            soft, damping = np.concatenate([soft, more], 1), np.concatenate([damping, more], 1)
        return self._cheapest(local, rows, error, soft, damping), np.sqrt(left[:, 0])

    def _cheapest(
        self, local: np.ndarray, rows: np.ndarray, error: np.ndarray, soft: np.ndarray, damping: np.ndarray
    ) -> np.ndarray:
        """Return the step (N, 7, 3): against the error (N, M), of which rows (N, M, 21) are the derivatives, and, where
        that changes nothing of it, back towards the joints as they were."""
        so_far = rotation.to_axis_angle(rotation.multiply(rotation.conjugate(self.local), local))
        so_far = so_far.reshape(len(local), -1)
        weighted = rows * self.free
        normal, unit = weighted @ rows.swapaxes(1, 2), np.eye(rows.shape[1])
        back = weighted.swapaxes(1, 2)
        solve = lambda values, softness: (
            back @ np.linalg.solve(normal + softness[:, :, None] * unit, values[..., None])
        )[..., 0]
        step = solve(error, damping) + BACK * (solve((rows @ so_far[..., None])[..., 0], soft) - so_far)
        step = step.reshape(len(local), -1, 3)
        largest = np.linalg.norm(step, axis=-1).max(-1)
        return step * np.minimum(1.0, LARGEST_STEP / np.maximum(largest, 1e-9))[:, None, None]

    def _within(self, local: np.ndarray) -> np.ndarray:
        """Return rotations no farther from the zero pose than they may be."""
        vector = rotation.to_axis_angle(local)
        angle = np.linalg.norm(vector, axis=-1)
        share = np.minimum(1.0, self.allowed / np.maximum(angle, 1e-9))
        return rotation.from_axis_angle(vector * share[..., None])
