"""Leaning back: a seated body whose posture asks for it rests its back on the seat's.

On deep seats people sit in front of the rest and recline until they touch it. The trunk is turned backward about the
hips, the spine rounds, the head stays up and the hands stay where they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .... import rotation, skeleton
from ....body import human
from ....easing import settling
from ....motion import Goal, Motion
from ....refine.inverse_kinematics import solve_limb

ASIDE, BEHIND = (
    0.17,
    0.5,
)  # metres aside of the pelvis and behind it in which the back of a seat is looked for
LOW, HIGH, STEP = 0.08, 0.62, 0.03  # metres over the pelvis
FEWEST = 2  # heights at which there is a surface, below which a seat has no back
MOST = np.radians(36.0)
UPRIGHT_MOST = np.radians(12.0)
"""Largest angle of a body that leans back, and of one that touches the rest only where it stays upright."""
STILL_UPRIGHT = np.radians(4.0)
"""Radians of the trunk, hips to neck, behind the vertical, up to which a body is upright, see vocabulary.POSTURES."""
TRIED = 13  # angles from 0 to the largest one
DURATION = 40.0  # frames at 30 fps
EARLY = 8  # frames before the pelvis is down at which the trunk begins to lean
SHORTEST = 20  # frames of rest below which there is no time to lean
SHARES = {"spine1": 0.7, "spine2": 1.0, "neck": 0.5, "head": 0.1}
PELVIS = 0.5
"""Shares of the angle by which joints are turned; joints between them follow their parents."""


@dataclass(frozen=True)
class SeatBack:
    """The back of a seat. heights: (H,) metres over the pelvis at the goal. behind: (H,) metres from the pelvis back
    to the surface at these heights, infinite where there is none. most: largest angle, radians, to lean."""

    heights: np.ndarray
    behind: np.ndarray
    most: float = MOST

    @classmethod
    def of(cls, points: np.ndarray, goal: Goal, most: float = MOST) -> SeatBack | None:
        """Return the back behind a goal, None where there is none. points: (N, 3) on the seat, twenty thousand."""
        away = points - goal.position
        direction = np.asarray(goal.direction, float)
        behind = -(away @ direction)
        aside = np.abs(away @ np.array([direction[2], 0.0, -direction[0]]))
        near = (behind > 0) & (behind < BEHIND) & (aside < ASIDE)
        heights = np.arange(LOW, HIGH, STEP)
        found = np.full(len(heights), np.inf)
        for k, height in enumerate(heights):
            row = behind[near & (np.abs(away[:, 1] - height) < STEP / 2)]
            if len(row) > 5:
                found[k] = np.percentile(row, 5)
        return cls(heights, found, most) if np.isfinite(found).sum() >= FEWEST else None

    def leaned_on(self, motion: Motion, goal: np.ndarray, seated: int) -> Motion:
        """Return the motion with the trunk on the back at the end, if it can be reached.

        goal: row of Route.goals. seated: frame from which the pelvis is down.
        """
        rest = len(motion) - seated
        angle = self._angle(motion, goal) if rest >= SHORTEST else 0.0
        if angle <= 0:
            return motion
        weight = settling(len(motion), seated, DURATION, EARLY)
        return leaned(motion, goal[3:6], angle * weight)

    def _angle(self, motion: Motion, goal: np.ndarray) -> float:
        """Return the angle, radians, at which the trunk of the last frame touches the back; 0 where none does."""
        tried = np.linspace(0.0, self.most, TRIED)
        last = motion.pose_slice(slice(len(motion) - 1, len(motion)))
        poses = replace(
            last,
            root=np.repeat(last.root, TRIED, 0),
            rotations=np.repeat(last.rotations, TRIED, 0),
            contacts=None,
            actions=None,
        )
        gap = self._gaps(leaned(poses, goal[3:6], tried), goal)
        touching = np.flatnonzero(gap <= 0)
        if not len(touching) or touching[0] == 0:
            return 0.0
        k = touching[0]
        # Rounded: the last bits of the skin depend on the number of threads, and takes must not.
        angle = round(float(np.interp(0.0, [gap[k], gap[k - 1]], [tried[k], tried[k - 1]])), 4)
        return angle if self.most > UPRIGHT_MOST or angle < _until_leaning(last, goal) else 0.0

    def _gaps(self, poses: Motion, goal: np.ndarray) -> np.ndarray:
        """Return the smallest distances (T,), metres, from the skin of the back to the seat's back."""
        body = human.load()
        skin = human.skin(body, poses, human.back_of(body)) - goal[:3]
        known = np.isfinite(self.behind)
        surface = np.interp(skin[..., 1], self.heights[known], self.behind[known])
        low, high = self.heights[known][[0, -1]] + [-STEP, STEP]
        beside = (skin[..., 1] > low) & (skin[..., 1] < high)
        return np.where(beside, surface + skin @ goal[3:6], np.inf).min(1)


def _until_leaning(pose: Motion, goal: np.ndarray) -> float:
    """Return the radians by which the trunk of a pose (one frame) can be turned backward and still is upright."""
    joints, index = pose.forward_kinematics()[0][0], skeleton.INDEX
    trunk = joints[index["neck"]] - (joints[index["left_hip"]] + joints[index["right_hip"]]) / 2
    return STILL_UPRIGHT - float(np.arctan2(-trunk @ goal[3:6], trunk[1]))


def leaned(motion: Motion, ahead: np.ndarray, angle: np.ndarray) -> Motion:
    """Return the motion with its trunk turned backward about the hips by angles (T,), radians.

    ahead: (3,) horizontal direction of the seated body. Legs and wrists stay where they are.
    """
    index, parents = skeleton.INDEX, skeleton.PARENTS
    left = np.cross([0.0, 1.0, 0.0], ahead)
    turn = lambda share: rotation.from_axis_angle(-share * angle[:, None] * left)
    positions, globals_ = motion.forward_kinematics()
    turned = {0: rotation.multiply(turn(PELVIS), globals_[:, 0])}
    turned |= {index[n]: rotation.multiply(turn(share), globals_[:, index[n]]) for n, share in SHARES.items()}
    turned |= {index[n]: globals_[:, index[n]] for n in ("left_hip", "right_hip")}
    rotations = motion.rotations.copy()
    rotations[:, 0] = turned[0]
    for joint in sorted(turned)[1:]:
        # All ancestors up to the next turned one follow it.
        above, between = parents[joint], []
        while above not in turned:
            between.append(above)
            above = parents[above]
        parent = turned[above]
        for link in reversed(between):
            parent = rotation.multiply(parent, motion.rotations[:, link])
        rotations[:, joint] = rotation.multiply(rotation.conjugate(parent), turned[joint])
    hips = (positions[:, index["left_hip"]] + positions[:, index["right_hip"]]) / 2 - motion.root
    root = motion.root + hips - rotation.rotate(turn(PELVIS), hips)
    for limb, wrist in (("left_arm", "left_wrist"), ("right_arm", "right_wrist")):
        rotations = solve_limb(root, rotations, motion.rest_joints, limb, positions[:, index[wrist]])
    return replace(motion, root=root, rotations=rotations)
