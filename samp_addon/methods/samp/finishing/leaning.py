"""Leaning back: a seated body whose posture asks for it rests its back on the seat's.

On deep seats people sit in front of the rest and recline until they touch it. The trunk is turned backward about the
hips, the spine rounds, the head stays up and the hands stay where they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .... import rotation, skeleton
from ....body import human
from ....easing import settling
from ....motion import Goal, Motion
from ....refine.inverse_kinematics import solve_limb

ASIDE, BEHIND = 0.2, 0.5  # metres aside of the pelvis and behind it in which the back of a seat is looked for
COLUMNS = 4  # of cells aside of the pelvis: the backs of armchairs are nearer at their sides
LOW, HIGH, STEP = 0.08, 0.62, 0.03  # metres over the pelvis
FEWEST = 2  # heights at which there is a surface, below which a seat has no back
NEAR = 25  # percentile of the points in a cell that counts as its surface
FEWEST_POINTS = 3  # in a cell, below which there is no surface in it
MOST = np.radians(40.0)
UPRIGHT_MOST = np.radians(12.0)
"""Largest angle of a body that leans back, and of one that touches the rest only where it stays upright."""
STILL_UPRIGHT = np.radians(4.0)
"""Radians of the trunk, hips to neck, behind the vertical, up to which a body is upright, see vocabulary.POSTURES."""
TRIED = 13  # angles from 0 to the largest one
DURATION = 40.0  # frames at 30 fps
EARLY = 8  # frames before the pelvis is down at which the trunk begins to lean
EVERY = 12  # frames between those at which the angle is looked for
SHORTEST = 20  # frames of rest below which there is no time to lean
SHARES = {"spine1": 0.7, "spine2": 1.0, "neck": 0.5, "head": 0.1}
PELVIS = 0.5
"""Shares of the angle by which joints are turned; joints between them follow their parents."""


@dataclass(frozen=True)
class SeatBack:
    """The back of a seat. heights: (H,) metres over the pelvis at the goal. behind: (H, COLUMNS) metres from the pelvis
    back to the surface at these heights, from the body's right to its left, infinite where there is none. most: largest
    angle, radians, to lean."""

    heights: np.ndarray
    behind: np.ndarray
    most: float = MOST

    @classmethod
    def of(cls, points: np.ndarray, goal: Goal, most: float = MOST) -> SeatBack | None:
        """Return the back behind a goal, None where there is none. points: (N, 3) on the seat, twenty thousand."""
        away = points - goal.position
        direction = np.asarray(goal.direction, float)
        behind, column = -(away @ direction), _columns(away, direction)
        near = (behind > 0) & (behind < BEHIND)
        heights = np.arange(LOW, HIGH, STEP)
        found = np.full((len(heights), COLUMNS), np.inf)
        for k, height in enumerate(heights):
            row = near & (np.abs(away[:, 1] - height) < STEP / 2)
            for c in range(COLUMNS):
                cell = behind[row & (column == c)]
                if len(cell) >= FEWEST_POINTS:
                    found[k, c] = np.percentile(cell, NEAR)
        enough = np.isfinite(found).any(1).sum() >= FEWEST
        return cls(heights, found, most) if enough else None

    def leaned_on(self, motion: Motion, goal: np.ndarray, seated: int) -> Motion:
        """Return the motion with the trunk on the back at the end, if it can be reached.

        goal: row of Route.goals. seated: frame from which the pelvis is down.
        """
        count = len(motion)
        if count - seated < SHORTEST:
            return motion
        last = self._angle(motion, count - 1, goal)
        if not last:
            return motion
        # A body at rest still moves, and its back shall stay on the seat's.
        frames = np.unique(np.append(np.arange(seated, count - 1, EVERY), count - 1))
        found = [self._angle(motion, k, goal) for k in frames[:-1]] + [last]
        angle = np.interp(np.arange(count), frames, [self.most if a is None else a for a in found])
        angle = gaussian_filter1d(angle, EVERY / 2, mode="nearest")
        return leaned(motion, goal[3:6], angle * settling(count, seated, DURATION, EARLY))

    def _angle(self, motion: Motion, frame: int, goal: np.ndarray) -> float | None:
        """Return the angle, radians, at which the trunk of a frame touches the back; None where none does."""
        tried = np.linspace(0.0, self.most, TRIED)
        pose = motion.pose_slice(slice(frame, frame + 1))
        poses = replace(
            pose,
            root=np.repeat(pose.root, TRIED, 0),
            rotations=np.repeat(pose.rotations, TRIED, 0),
            contacts=None,
            actions=None,
        )
        gap = self._gaps(leaned(poses, goal[3:6], tried), goal)
        touching = np.flatnonzero(gap <= 0)
        if not len(touching):
            return None
        k = touching[0]
        if k == 0:
            return 0.0
        # Rounded: the last bits of the skin depend on the number of threads, and takes must not.
        angle = round(float(np.interp(0.0, [gap[k], gap[k - 1]], [tried[k], tried[k - 1]])), 4)
        return angle if self.most > UPRIGHT_MOST or angle < _until_leaning(pose, goal) else None

    def _gaps(self, poses: Motion, goal: np.ndarray) -> np.ndarray:
        """Return the smallest distances (T,), metres, from the skin of the back to the seat's back."""
        body = human.load()
        skin = human.skin(body, poses, human.back_of(body)) - goal[:3]
        height, column = skin[..., 1], _columns(skin, goal[3:6])
        gap = np.full(height.shape, np.inf)
        for c in range(COLUMNS):
            known = np.isfinite(self.behind[:, c])
            if not known.any():
                continue
            low, high = self.heights[known][[0, -1]] + [-STEP, STEP]
            beside = (column == c) & (height > low) & (height < high)
            surface = np.interp(height[beside], self.heights[known], self.behind[known, c])
            gap[beside] = surface + skin[beside] @ goal[3:6]
        return gap.min(1)


def _columns(away: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Return the column of the seat's back, 0 to COLUMNS - 1, of vectors (..., 3) from the goal, or others aside of it.

    ahead: (3,) horizontal direction of the goal.
    """
    left = away @ np.cross([0.0, 1.0, 0.0], ahead)
    return np.floor((left + ASIDE) * COLUMNS / (2 * ASIDE)).astype(int)


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
