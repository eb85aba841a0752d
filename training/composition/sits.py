"""Sits on furniture: captured sits adapted to seats of other heights, with long approaches (paper, section 4.2).

The piece of furniture is moved to the sit, not the sit to the piece: its goal coincides with the seated pelvis.
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
SIDEWAYS = 0.15  # share of the sits that face over the seat's side or corner
TURNS = (np.radians(35), np.radians(95))  # range of angles between their facing and the seat's
PACES = (0.85, 1.2)
ALL_PACES = 0.5  # share of the sits with a changed pace
PILLOW = 0.16  # metres above and below the mattress that count as its surface
SUNK = 0.05  # largest penetration of the surface, metres
TOUCH = 0.07  # largest gap or penetration (m) between buttocks and seat
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
    """A piece with its goals: surface points (N, 3), metres, and goals in the piece's frame."""

    index: int
    surface: np.ndarray
    goals: list[Goal]


def lifted(clip: Clip, event_pelvis: float, lift: float) -> Clip:
    """Return the clip with its seated pelvis raised by ``lift`` metres; standing frames stay."""
    standing = np.percentile(clip.root[:, 1], 95)
    weight = smoothstep((standing - clip.root[:, 1]) / max(standing - event_pelvis, 0.05))
    return replace(clip, root=clip.root + np.outer(weight * lift, [0.0, 1.0, 0.0]))


def placement(goal: Goal, pelvis: np.ndarray, yaw: float) -> tuple[float, float, float]:
    """Return (x, z, yaw), metres and radians, that place a piece's goal at a pelvis (3,) facing yaw."""
    turn = yaw - np.arctan2(goal.direction[0], goal.direction[2])
    there = rotation.rotate(rotation.about_y(turn), goal.position)
    return float(pelvis[0] - there[0]), float(pelvis[2] - there[2]), float(turn)


def _probe_points(clip: Clip, place: tuple[float, float, float]) -> np.ndarray:
    """Return the midpoints of limbs and trunk (T, 12, 3) in the frame of a piece with this placement."""
    positions, _ = skeleton.forward_kinematics(clip.root, clip.rotations, skeleton.default_rest_joints())
    points = np.stack([(positions[:, a] + positions[:, b]) / 2 for a, b in _BONES], 1)
    away = points - np.array([place[0], 0.0, place[1]])
    return rotation.rotate(np.broadcast_to(rotation.about_y(-place[2]), (*away.shape[:2], 4)), away)


def sunk(lying: Clip, piece: Furnishing, place: tuple[float, float, float], mattress: float) -> str | None:
    """Return why a lying body does not fit the surface of a piece, or None. mattress: its height, metres."""
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
    """Return why a motion collides with a piece, or None. seated: (T,) flags of frames on the seat."""
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
    """Flag points (T, K, 3) with the piece's surface above and around them, such as legs inside a closed bed or sofa.

    Only surfaces lower than a table count, so that legs may be under tables.
    """
    above = surface[surface[:, 1] < 0.62]
    if not len(above):
        return np.zeros(points.shape[:2], bool)
    flat = points.reshape(-1, 3)
    near = cKDTree(above[:, [0, 2]]).query_ball_point(flat[:, [0, 2]], 0.06)
    covered = [len(k) > 1 and np.max(above[k, 1]) > p[1] + 0.05 for k, p in zip(near, flat, strict=True)]
    return np.array(covered).reshape(points.shape[:2])


def untouched(pelvis: np.ndarray, piece: Furnishing, place: tuple[float, float, float]) -> str | None:
    """Return why a seated pelvis (3,) does not rest on a piece, or None."""
    local = rotation.rotate(rotation.about_y(-place[2]), pelvis - np.array([place[0], 0.0, place[1]]))
    away = piece.surface - local
    below = (np.hypot(away[:, 0], away[:, 2]) < 0.12) & (away[:, 1] < -0.05)
    if below.sum() < 3:
        return "nothing under it"
    gap = -SEAT_TO_PELVIS - float(np.percentile(away[below, 1], 90))
    return "hovers over it" if gap > TOUCH else "sits too deep" if gap < -TOUCH else None


def of_one_height(heights: np.ndarray, first: int, most: int, rng: np.random.Generator) -> list[int]:
    """Return the index ``first`` and up to ``most`` - 1 random others within two centimetres of its height."""
    alike = np.flatnonzero(np.abs(heights - heights[first]) < 0.02)
    return [first, *rng.permutation(alike[alike != first])[: most - 1]]


class Composer:
    """Compose sit sequences from events, pieces and walks; report counts kept and dropped ones by reason.

    plain: sits stay as captured, on pieces of exactly their height (the ablation without augmentation).
    """

    def __init__(self, pieces: list[Furnishing], walks: WalkIndex, seed: int, plain: bool = False) -> None:
        self.walks = walks
        self.plain = plain
        self.rng = np.random.default_rng(seed)
        self.report: Counter[str] = Counter()
        self.seats = [(piece, goal) for piece in pieces for goal in piece.goals]
        self.heights = np.array([goal.position[1] for _, goal in self.seats])

    def compose(self, event: SitEvent) -> Sequence | None:
        """Return a sequence from an event, or None.

        It has a lift to a seat's height, an approach, a hold and optionally standing up, on the first of some pieces of
        that height without a collision.
        """
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
        """Return the goal, turned for a sideways sit in SIDEWAYS of the cases, and whether it is."""
        if self.plain or self.rng.random() > SIDEWAYS:
            return goal, False
        turn = self.rng.choice([-1.0, 1.0]) * self.rng.uniform(*TURNS)
        return replace(goal, direction=rotation.rotate(rotation.about_y(turn), goal.direction)), True

    def _paced(self, clip: Clip, frames: dict[str, int]) -> tuple[Clip, dict[str, int]]:
        """Return the excerpt at a random pace, and its key frames."""
        factor = self.rng.uniform(*PACES)
        quick = paced(clip, factor)
        return quick, {name: min(round(at / factor), len(quick) - 1) for name, at in frames.items()}

    def _seats_of_one_height(self, event: SitEvent, most: int = 12) -> list[tuple[Furnishing, Goal]]:
        """Return seats within the lift's range: a random one, and others within two centimetres of its height."""
        lift = 0.02 if self.plain else MOST_LIFT
        fits = np.flatnonzero(np.abs(self.heights - event.pelvis[1]) < lift)
        if not len(fits):
            return []
        first = self.rng.choice(fits)
        return [self.seats[k] for k in of_one_height(self.heights, first, most, self.rng)]

    def _excerpt(self, event: SitEvent) -> tuple[Clip, dict[str, int]]:
        """Return the event's own frames, from its approach to the end of the hold or of leaving, and its key frames."""
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
        """Return the event with a captured walk prepended, joined at a matching random frame, and its key frames."""
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
        """Return the sequence with its goals: optionally a way-point, the seat, then way-points after standing up."""
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
