"""Plans of feet: where each ankle is, and how it is turned, while its foot stands on the ground under it.

Nothing is known of the motion but its joints; a ground is queried for the heights under the soles. Network frame,
metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ... import rotation
from ...easing import smoothstep
from ...motion import Motion
from .. import hovering
from ..field import Ground
from .foot import FEET, Foot, sole_offsets
from .stances import Stance, bridge, from_ground, standing

OVER = 0.002  # metres that soles are kept over the ground
MAX_TILT = np.radians(25.0)  # by which a foot is tilted to lie flat on its ground
ROLLED = np.radians(40.0)  # pitch from which a rolling foot may twist and tilt freely


@dataclass(frozen=True)
class FootPlan:
    """The plan of one foot.

    ankle: (T, 3) positions and orientation: (T, 4) global quaternions of the ankle joint. standing: (T,) flags.
    stances: in order of time.
    """

    foot: Foot
    ankle: np.ndarray
    orientation: np.ndarray
    standing: np.ndarray
    stances: tuple[Stance, ...]

    def ball(self, rest_joints: np.ndarray) -> np.ndarray:
        """Return the planned positions (T, 3) of the ball joint of a body with rest joints (J, 3)."""
        bone = rest_joints[self.foot.ball] - rest_joints[self.foot.ankle]
        return self.ankle + rotation.rotate(self.orientation, np.broadcast_to(bone, self.ankle.shape))

    def cut(self, part: slice) -> FootPlan:
        """Return the plan of some frames, without its stances."""
        return replace(
            self,
            ankle=self.ankle[part],
            orientation=self.orientation[part],
            standing=self.standing[part],
            stances=(),
        )


def plan_feet(motion: Motion, ground: Ground, known: Sequence[FootPlan] | None = None) -> list[FootPlan]:
    """Plan both feet of a motion, right one first.

    known: plans of the same take at an earlier stage, whose stances are kept.
    """
    tracks = _tracks(motion, ground)
    if known is not None:
        stances = [plan.stances for plan in known]
    else:
        stances = [track.stances(motion.fps) for track in tracks]
        stances = bridge(stances, hovering.supported(motion), motion.fps)
    return [track.plan(its) for track, its in zip(tracks, stances, strict=True)]


def lowest_ground(motion: Motion, ground: Ground) -> float | None:
    """Return the height of the lowest ground that a foot stands on, or None where no foot stands on any."""
    heights = []
    for track in _tracks(motion, ground):
        for stance in track.stances(motion.fps):
            under = np.concatenate([height[stance.first : stance.last] for height, _ in track.grounds])
            heights += [float(np.nanmedian(under))] if np.isfinite(under).any() else []
    return min(heights, default=None)


@dataclass(frozen=True)
class _Track:
    """A foot as it moves. ankle: (T, 3). orientation: (T, 4) global. sole: heel and ball in the ankle's frame, (3,)
    each. ends: both as they move, (T, 3) each. grounds: heights (T,) and normals (T, 3) of the ground under each."""

    foot: Foot
    ankle: np.ndarray
    orientation: np.ndarray
    sole: tuple[np.ndarray, np.ndarray]
    ends: list[np.ndarray]
    grounds: list[tuple[np.ndarray, np.ndarray]]

    def stances(self, fps: float) -> list[Stance]:
        heights = [end[:, 1] - height for end, (height, _) in zip(self.ends, self.grounds, strict=True)]
        up = rotation.rotate(self.orientation, np.broadcast_to([0.0, 1.0, 0.0], self.ankle.shape))[:, 1]
        return from_ground(self.ends, heights, up, fps)

    def plan(self, stances: Sequence[Stance]) -> FootPlan:
        ankle, orientation = self.ankle.copy(), self.orientation.copy()
        for stance in stances:
            self._pin(stance, ankle, orientation)
        return FootPlan(self.foot, ankle, orientation, standing(stances, len(ankle)), tuple(stances))

    def _pin(self, stance: Stance, ankle: np.ndarray, orientation: np.ndarray) -> None:
        """Write a stance into ankle positions (T, 3) and quaternions (T, 4).

        While it is flat the whole foot is still; before and after it rolls over heel or ball.
        """
        first, last = stance.first, stance.last
        a, b = stance.flat or (first, first)
        if stance.flat is not None:
            still, place, middle = self._flat_pose(slice(a, b), orientation)
            own = orientation[first:last].copy()
            # Before and after its flat part the foot rolls as it did, starting from the pinned pose.
            base = np.clip(np.arange(first, last), a, b - 1) - first
            roll = pitch_first(rotation.multiply(own, rotation.conjugate(own[base])), still, self.sole)
            orientation[first:last] = rotation.multiply(roll, np.broadcast_to(still, roll.shape))
            orientation[a:b] = still
            ankle[a:b] = place
        else:
            part = slice(first, last)
            middle = [end[part].mean(0) for end in self.ends]
            for at, end, (height, _) in zip(middle, self.ends, self.grounds, strict=True):
                low = end[part, 1].min()
                at[1] = max(low, _mean_height(height[part], low) + OVER)
        for t in [*range(first, a), *range(b, last)]:
            corners = rotation.rotate(np.stack([orientation[t], orientation[t]]), np.stack(self.sole))
            pivot = int(corners[1, 1] < corners[0, 1])
            ankle[t] = middle[pivot] - corners[pivot]

    def _flat_pose(
        self, part: slice, orientation: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        """Return the pose of a foot that stands flat on the ground in some frames: the ankle's quaternion (4,) and
        position (3,), and the positions of heel and ball, (3,) each."""
        still = rotation.normalise(rotation.continuous(orientation[part]).mean(0))
        normal = np.mean([normals[part].mean(0) for _, normals in self.grounds], axis=0)
        length = np.linalg.norm(normal)
        normal = normal / length if length > 0.5 else np.array([0.0, 1.0, 0.0])  # no ground near
        own_up = rotation.rotate(still[None], np.array([[0.0, 1.0, 0.0]]))
        tilt = rotation.to_axis_angle(rotation.between(own_up, normal[None]))
        tilt *= min(1.0, MAX_TILT / max(float(np.linalg.norm(tilt)), 1e-9))
        still = rotation.multiply(rotation.from_axis_angle(tilt), still[None])[0]
        corners = rotation.rotate(np.stack([still, still]), np.stack(self.sole))
        place = np.mean([end[part] for end in self.ends], axis=(0, 1)) - corners.mean(0)
        heights = [
            _mean_height(height[part], end[part, 1].mean())
            for (height, _), end in zip(self.grounds, self.ends, strict=True)
        ]
        place[1] = (
            np.mean([height - corner[1] for height, corner in zip(heights, corners, strict=True)]) + OVER
        )
        return still, place, [place + corner for corner in corners]


def _tracks(motion: Motion, ground: Ground) -> list[_Track]:
    """Return the tracks of both feet, right one first."""
    positions, globals_ = motion.forward_kinematics()
    tracks = []
    for foot in FEET:
        ankle, orientation = positions[:, foot.ankle], globals_[:, foot.ankle]
        sole = sole_offsets(motion.rest_joints, foot.side)
        ends = [ankle + rotation.rotate(orientation, np.broadcast_to(point, ankle.shape)) for point in sole]
        tracks.append(_Track(foot, ankle, orientation, sole, ends, [ground.support(end) for end in ends]))
    return tracks


def pitch_first(roll: np.ndarray, still: np.ndarray, sole: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return rolls (N, 4) of a foot, twist and tilt removed as long as the sole has hardly left the ground.

    A foot that rolls over its heel or ball does not twist on the floor. still: quaternion (4,) of the standing foot.
    sole: heel and ball in the ankle's frame.
    """
    heel, ball = rotation.rotate(np.stack([still, still]), np.stack(sole))
    across = np.cross([0.0, 1.0, 0.0], ball - heel)
    across /= np.linalg.norm(across)
    vector = rotation.to_axis_angle(rotation.continuous(roll))
    pitch = (vector @ across)[:, None] * across
    risen = smoothstep(np.linalg.norm(pitch, axis=-1, keepdims=True) / ROLLED)
    return rotation.from_axis_angle(pitch + risen * (vector - pitch))


def _mean_height(heights: np.ndarray, fallback: float) -> float:
    """Return the mean of ground heights (N,) without NaN, or the fallback where all are NaN."""
    return float(np.nanmean(heights)) if np.isfinite(heights).any() else float(fallback)
