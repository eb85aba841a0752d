"""Sits on furniture: real sits carried to seats of other heights, approached from afar (section 4.2).

The piece of furniture is put under the sit, not the sit onto the piece: its goal coincides with the seated pelvis.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...samp_addon import rotation, skeleton
from ...samp_addon.easing import smoothstep
from ...samp_addon.motion import Goal
from ...samp_addon.scene.seats.postures import SEAT_TO_PELVIS
from ..mocap.augment import paced, relocked
from ..mocap.clip_files import Clip
from ..mocap.events import SitEvent, headings
from .checks import fault
from .sequence import Sequence
from .stitch import WalkIndex, clean_start, join, pose_features
from .walks import by_way_point, way_points

LONGEST_HOLD = 240  # frames of sitting kept in one sequence
MOST_LIFT = 0.15  # metres by which a sit may be raised or lowered to another seat
SIDEWAYS = 0.15  # share of the sits that face another way than the seat does: over its side, over a corner
TURNS = (np.radians(35), np.radians(95))  # by which they do
PACES = (0.85, 1.2)
ALL_PACES = 0.5  # share of the sits that are made slower or faster
PILLOW = 0.16  # metres over and under the mattress that count as its surface
SUNK = 0.05  # metres
TOUCH = 0.07  # metres that the seat's surface may be off from under the buttocks
_BONES = [
    (1, 4),
    (2, 5),
    (4, 7),
    (5, 8),
    (16, 18),
    (17, 19),
    (18, 20),
    (19, 21),
    (3, 6),
    (6, 9),
    (9, 12),
    (12, 15),
]
_RADII = np.array([0.07, 0.07, 0.05, 0.05, 0.05, 0.05, 0.04, 0.04, 0.11, 0.11, 0.11, 0.08])


@dataclass(frozen=True)
class Furnishing:
    """A piece with its goals: surface points (N, 3), goals in its own frame."""

    index: int
    surface: np.ndarray
    goals: list[Goal]


def lifted(clip: Clip, event_pelvis: float, lift: float) -> Clip:
    """The clip with its seated pelvis raised by ``lift`` metres; standing frames stay."""
    standing = np.percentile(clip.root[:, 1], 95)
    weight = smoothstep((standing - clip.root[:, 1]) / max(standing - event_pelvis, 0.05))
    return replace(clip, root=clip.root + np.outer(weight * lift, [0.0, 1.0, 0.0]))


def placement(goal: Goal, pelvis: np.ndarray, yaw: float) -> tuple[float, float, float]:
    """(x, z, yaw) that puts a piece's goal under a pelvis at (3,) that faces yaw."""
    turn = yaw - np.arctan2(goal.direction[0], goal.direction[2])
    there = rotation.rotate(rotation.about_y(turn), goal.position)
    return float(pelvis[0] - there[0]), float(pelvis[2] - there[2]), float(turn)


def _probe_points(clip: Clip, place: tuple[float, float, float]) -> np.ndarray:
    """Middle points of the limbs and the trunk (T, 12, 3) in the frame of a piece that stands at a place."""
    positions, _ = skeleton.forward_kinematics(clip.root, clip.rotations, skeleton.default_rest_joints())
    points = np.stack([(positions[:, a] + positions[:, b]) / 2 for a, b in _BONES], 1)
    away = points - np.array([place[0], 0.0, place[1]])
    return rotation.rotate(np.broadcast_to(rotation.about_y(-place[2]), (*away.shape[:2], 4)), away)


def sunk(lying: Clip, piece: Furnishing, place: tuple[float, float, float], mattress: float) -> str | None:
    """Why a body that lies on a piece all along does not fit its surface, or None. mattress: its height."""
    local = _probe_points(lying, place)[::4]
    top = piece.surface[np.abs(piece.surface[:, 1] - mattress) < PILLOW]
    flat = local.reshape(-1, 3)
    near = cKDTree(top[:, [0, 2]]).query_ball_point(flat[:, [0, 2]], 0.06)
    level = np.array([np.percentile(top[k, 1], 90) if len(k) > 1 else -np.inf for k in near])
    deep = level.reshape(local.shape[:2]) + 0.6 * _RADII - local[..., 1] > SUNK
    if deep[:, 8:].any(1).mean() > 0.2:
        return "trunk in the mattress"
    return "limbs in the mattress" if deep[:, :8].any(1).mean() > 0.3 else None


def collides(
    clip: Clip, piece: Furnishing, place: tuple[float, float, float], seated: np.ndarray
) -> str | None:
    """Why the motion and the piece do not go together, or None. seated: (T,) frames on the seat."""
    local = _probe_points(clip, place)[::3]
    distance = (
        cKDTree(piece.surface)
        .query(local.reshape(-1, 3), distance_upper_bound=0.3)[0]
        .reshape(local.shape[:2])
    )
    deep = distance < 0.55 * _RADII
    sat = seated[::3]
    if (~sat).any() and _inside(local[~sat][:, 2:4], piece.surface).any(1).mean() > 0.03:
        return "stands in it"
    if (~sat).any() and deep[~sat][:, 2:].any(1).mean() > 0.03:
        return "walks into it"
    if sat.any() and deep[sat][:, 2:8].any(1).mean() > 0.15:
        return "limbs in it"
    if sat.any() and deep[sat][:, 8:].any(1).mean() > 0.15:
        return "trunk in it"
    return None


def _inside(points: np.ndarray, surface: np.ndarray) -> np.ndarray:
    """Which points (T, K, 3) have the piece's surface both above and around them: legs in a closed bed or sofa.

    Only what is lower than a table counts, so that legs may be under tables.
    """
    above = surface[surface[:, 1] < 0.62]
    if not len(above):
        return np.zeros(points.shape[:2], bool)
    flat = points.reshape(-1, 3)
    near = cKDTree(above[:, [0, 2]]).query_ball_point(flat[:, [0, 2]], 0.06)
    covered = [len(k) > 1 and np.max(above[k, 1]) > p[1] + 0.05 for k, p in zip(near, flat, strict=True)]
    return np.array(covered).reshape(points.shape[:2])


def untouched(pelvis: np.ndarray, piece: Furnishing, place: tuple[float, float, float]) -> str | None:
    """Why a seated pelvis (3,) does not rest on a piece, or None."""
    local = rotation.rotate(rotation.about_y(-place[2]), pelvis - np.array([place[0], 0.0, place[1]]))
    away = piece.surface - local
    below = (np.hypot(away[:, 0], away[:, 2]) < 0.12) & (away[:, 1] < -0.05)
    if below.sum() < 3:
        return "nothing under it"
    gap = -SEAT_TO_PELVIS - float(np.percentile(away[below, 1], 90))
    return "hovers over it" if gap > TOUCH else "sits too deep" if gap < -TOUCH else None


def of_one_height(heights: np.ndarray, first: int, most: int, rng: np.random.Generator) -> list[int]:
    """The index ``first`` and up to ``most`` - 1 random others within two centimetres of its height."""
    alike = np.flatnonzero(np.abs(heights - heights[first]) < 0.02)
    return [first, *rng.permutation(alike[alike != first])[: most - 1]]


class Composer:
    """Makes sit sequences out of events, pieces and walks; counts what it dropped and why.

    plain: sits stay as they were captured, on pieces of just their height (the ablation without augmentation).
    """

    def __init__(self, pieces: list[Furnishing], walks: WalkIndex, seed: int, plain: bool = False) -> None:
        self.walks = walks
        self.plain = plain
        self.rng = np.random.default_rng(seed)
        self.report: Counter[str] = Counter()
        self.seats = [(piece, goal) for piece in pieces for goal in piece.goals]
        self.heights = np.array([goal.position[1] for _, goal in self.seats])

    def compose(self, event: SitEvent) -> Sequence | None:
        """One sequence from an event: a seat's height, lift, approach, hold and perhaps standing up again, on the
        first of some pieces of that height that the motion does not run into."""
        seats = self._seats_of_one_height(event)
        if not seats:
            self.report["no seat of that height"] += 1
            return None
        clip, frames = self._excerpt(event)
        if not self.plain and self.rng.random() < ALL_PACES:
            clip, frames = self._paced(clip, frames)
        clip = relocked(lifted(clip, event.pelvis[1], seats[0][1].position[1] - event.pelvis[1]))
        if not self.plain and self.rng.random() < 0.75 and frames["down"] > 12:
            clip, frames = self.approach(clip, frames)
        middle = slice(frames["seated"] + 3, frames["seat_end"])
        yaw_all = headings(clip.root, clip.rotations)
        yaw = np.arctan2(np.sin(yaw_all[middle]).mean(), np.cos(yaw_all[middle]).mean())
        pelvis = np.median(clip.root[middle], axis=0)
        near_seat = np.zeros(len(clip), bool)
        near_seat[frames["down"] : frames["up_end"] + 1] = True
        why = fault(clip)
        for piece, straight in seats if why is None else ():
            goal, sideways = self._turned(straight)
            place = placement(goal, pelvis, yaw)
            why = collides(clip, piece, place, near_seat) or untouched(pelvis, piece, place)
            if why is None:
                self.report["kept"] += 1
                self.report["of these sideways"] += int(sideways)
                return self._sequence(clip, frames, piece.index, place, pelvis, yaw, yaw_all)
        self.report[why] += 1
        return None

    def _turned(self, goal: Goal) -> tuple[Goal, bool]:
        """The goal, now and then turned so that one sits sideways, and whether it is."""
        if self.plain or self.rng.random() > SIDEWAYS:
            return goal, False
        turn = self.rng.choice([-1.0, 1.0]) * self.rng.uniform(*TURNS)
        return replace(goal, direction=rotation.rotate(rotation.about_y(turn), goal.direction)), True

    def _paced(self, clip: Clip, frames: dict[str, int]) -> tuple[Clip, dict[str, int]]:
        """The excerpt, slower or faster."""
        factor = self.rng.uniform(*PACES)
        quick = paced(clip, factor)
        return quick, {name: min(round(at / factor), len(quick) - 1) for name, at in frames.items()}

    def _seats_of_one_height(self, event: SitEvent, most: int = 12) -> list[tuple[Furnishing, Goal]]:
        """Seats within reach of the event's lift: a random one, and others within two centimetres of its height."""
        lift = 0.02 if self.plain else MOST_LIFT
        fits = np.flatnonzero(np.abs(self.heights - event.pelvis[1]) < lift)
        if not len(fits):
            return []
        first = self.rng.choice(fits)
        return [self.seats[k] for k in of_one_height(self.heights, first, most, self.rng)]

    def _excerpt(self, event: SitEvent) -> tuple[Clip, dict[str, int]]:
        """The event's own frames, from its approach to the end of the hold or of leaving."""
        last = event.seat_end
        long_sit = event.seat_end - event.seated > LONGEST_HOLD
        if long_sit:
            last = event.seated + LONGEST_HOLD
        elif event.up_end > event.seat_end:
            last = event.leave_end
        clip = event.clip.cut(event.entry, last + 1)
        frames = {
            "down": event.down - event.entry,
            "seated": event.seated - event.entry,
            "seat_end": min(event.seat_end, last) - event.entry,
            "up_end": min(event.up_end, last) - event.entry,
        }
        return clip, frames

    def approach(self, clip: Clip, frames: dict[str, int]) -> tuple[Clip, dict[str, int]]:
        """A real walk in front of the event, joined where it matches best among some random frames."""
        features = pose_features(clip.root, clip.rotations)
        for _ in range(6):
            entry = int(self.rng.integers(2, max(frames["down"] - 8, 3)))
            found = self.walks.matches(features[entry], 25, 0.75)
            if not found:
                continue
            number, frame = found[self.rng.integers(len(found))]
            walk = self.walks.clips[number]
            start = clean_start(walk, frame, int(self.rng.integers(30, 170)))
            if frame - start < 15:
                continue
            joined = relocked(join(walk.cut(start, frame + 1), clip.cut(entry, len(clip))))
            shift = (frame - start) - entry
            return joined, {name: at + shift for name, at in frames.items()}
        self.report["no walk matched"] += 1
        return clip, frames

    def _sequence(
        self, clip: Clip, frames: dict[str, int], piece: int, place: tuple[float, float, float],
        pelvis: np.ndarray, yaw: float, yaw_all: np.ndarray,
    ) -> Sequence:  # fmt: skip
        """Goals: perhaps a way-point first, then the seat, then wherever the clip goes after standing up."""
        count = len(clip)
        goal = np.tile([*pelvis, np.sin(yaw), 0.0, np.cos(yaw)], (count, 1))
        action = np.full(count, 3)
        by_way_point(goal, action, clip.root, yaw_all, frames["down"], self.rng)
        if count > frames["up_end"] + 20:
            leave = frames["seat_end"] - int(self.rng.integers(0, 12))
            goal[leave:], action[leave:] = way_points(clip.root, yaw_all, clip.labels, leave, count, self.rng)
        ends_seated = frames["seat_end"] >= count - 2
        return Sequence(
            "sit", clip.root, clip.rotations, clip.labels, clip.feet, clip.bad, goal, action, piece, place,
            open_start=True, open_end=not ends_seated and clip.labels[-1] in ("walk", "run"),
        )  # fmt: skip
