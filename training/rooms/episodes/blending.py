"""Join captured pieces into one motion by inertial blending: the offset at a join decays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....samp_addon import rotation
from .bank import Bank

DECAY = 0.36  # rate (1/frame) of the critically damped blend: an offset is halved after 5 frames
FADE = 32  # frames after which the offset is zero
LEAD = 2  # frames of a piece before its first one, which define its initial velocity


@dataclass
class Piece:
    """A piece of motion in the room.

    root: (LEAD + T, 3) metres. rotations: (LEAD + T, 22, 4). labels: (T,) indices into bank.LABELS. feet: (T, 2)
    contacts of right and left foot. source: (T,) bank frames, -1 where not captured. hands: (T, 2) contacts of right
    and left hand. object: (T,) number of the piece of furniture in use, -1 for none.
    """

    root: np.ndarray
    rotations: np.ndarray
    labels: np.ndarray
    feet: np.ndarray
    source: np.ndarray
    hands: np.ndarray
    object: np.ndarray

    def __len__(self) -> int:
        return len(self.labels)

    def part(self, start: int, stop: int) -> Piece:
        """Return frames start .. stop - 1 of a piece without lead."""
        return Piece(*(getattr(self, name)[start:stop] for name in self.__dataclass_fields__))


def from_bank(bank: Bank, first: int, flat: np.ndarray) -> Piece:
    """Return the bank's frames from ``first`` on, placed on a route: flat (T, 3) x, z, yaw."""
    count = len(flat)
    frames = np.arange(first - LEAD, first + count)
    source = bank.flat[frames]
    turn = np.concatenate([np.repeat(flat[0, 2] - source[LEAD, 2], LEAD), flat[:, 2] - source[LEAD:, 2]])
    # The lead keeps its captured motion relative to the first frame.
    before = source[:LEAD, :2] - source[LEAD, :2]
    c, s = np.cos(turn[0]), np.sin(turn[0])
    before = np.column_stack([before[:, 0] * c + before[:, 1] * s, -before[:, 0] * s + before[:, 1] * c])
    ground = np.concatenate([flat[0, :2] + before, flat[:, :2]])
    quarter = rotation.about_y(turn)
    sway = bank.root[frames] - np.column_stack([source[:, 0], np.zeros(len(frames)), source[:, 1]])
    root = rotation.rotate(quarter, sway) + np.column_stack(
        [ground[:, 0], np.zeros(len(frames)), ground[:, 1]]
    )
    rotations = bank.rotations[frames].astype(np.float64)
    rotations[:, 0] = rotation.multiply(quarter, rotations[:, 0])
    own = frames[LEAD:]
    nothing = np.zeros((count, 2), np.float32)
    return Piece(
        root, rotations, bank.labels[own], bank.feet[own], own.astype(np.int32), nothing, np.full(count, -1)
    )


def joined(pieces: list[Piece]) -> Piece:
    """Return all pieces as one, without lead; each starts with the pose and the velocity of the previous one."""
    root, rotations = pieces[0].root[LEAD:], pieces[0].rotations[LEAD:]
    roots, turns = [root], [rotations]
    for piece in pieces[1:]:
        last_root = np.concatenate([a[-2:] for a in roots[-2:]])[-2:]
        last_turn = np.concatenate([a[-2:] for a in turns[-2:]])[-2:]
        new_root, new_turn = _led_in(last_root, last_turn, piece)
        roots.append(new_root)
        turns.append(new_turn)
    cat = lambda name: np.concatenate([getattr(piece, name) for piece in pieces])
    return Piece(
        np.concatenate(roots), rotation.continuous(rotation.normalise(np.concatenate(turns))), cat("labels"),
        cat("feet"), cat("source"), cat("hands"), cat("object"),
    )  # fmt: skip


def _led_in(last_root: np.ndarray, last_turn: np.ndarray, piece: Piece) -> tuple[np.ndarray, np.ndarray]:
    """Return root (T, 3) and rotations (T, 22, 4) of a piece that continues two frames: (2, 3) and (2, 22, 4)."""
    root, turns = piece.root[LEAD:].copy(), piece.rotations[LEAD:].copy()
    count = min(FADE, len(root))
    gap = last_root - piece.root[:LEAD]
    relative = rotation.multiply(last_turn, rotation.conjugate(piece.rotations[:LEAD]))
    angle = rotation.to_axis_angle(relative)  # (2, 22, 3)
    time = np.arange(1, count + 1)
    root[:count] += _damped(gap[1], gap[1] - gap[0], time)
    speed = rotation.to_axis_angle(rotation.multiply(relative[1], rotation.conjugate(relative[0])))
    offset = _damped(angle[1], speed, time)
    turns[:count] = rotation.multiply(rotation.from_axis_angle(offset), turns[:count])
    return root, turns


def _damped(offset: np.ndarray, speed: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return the remainder (T, ...) of an offset with a velocity per frame, after numbers of frames (T,)."""
    time = time.reshape(-1, *([1] * offset.ndim))
    return np.exp(-DECAY * time) * (offset + (speed + DECAY * offset) * time)
