"""Windows in their rooms: conversion to Motions, non-collision and contact (table 2), optimisation (section 3.4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch

from ....models.long_term import layout
from ....samp_addon import rotation
from ....samp_addon.body import betas as shapes
from ....samp_addon.body.human import Human
from ....samp_addon.evaluation import collision, feet
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.motion import Motion
from ....samp_addon.refine import refinement
from ...rooms.corpus.store import Corpus
from ..data import LongTermData, Windows
from .predicted import Predicted

FLOOR = 0.0  # floor height of all rooms of the corpus, metres


def body(windows: Windows, row: int) -> Human:
    """Return the body of a window."""
    return shapes.body_of(windows.betas[row].double().cpu().numpy())


def motions(data: LongTermData, windows: Windows, made: Predicted) -> list[Motion]:
    """Return windows, which must not be mirrored, as Motions in their rooms."""
    origins, yaws = places(data, windows)
    found = []
    for k, (origin, yaw) in enumerate(zip(origins, yaws, strict=True)):
        turn = rotation.about_y(yaw)
        root = made.route[k, :, :3].double().cpu().numpy()
        root = rotation.rotate(np.broadcast_to(turn, (len(root), 4)), root) + origin
        matrices = torch.cat([layout.matrix_from_six(made.route[k, :, 3:])[:, None], made.turns[k]], 1)
        quats = rotation.matrix_to_quaternion(matrices.double().cpu().numpy())
        quats[:, 0] = rotation.multiply(np.broadcast_to(turn, quats[:, 0].shape), quats[:, 0])
        found.append(Motion(root, rotation.continuous(quats), rest_joints=body(windows, k).joints))
    return found


def from_motions(data: LongTermData, windows: Windows, made: Sequence[Motion]) -> Predicted:
    """Return Motions in their rooms as windows in the frame of their start."""
    origins, yaws = places(data, windows)
    routes, turns = [], []
    for motion, origin, yaw in zip(made, origins, yaws, strict=True):
        back = rotation.about_y(-yaw)
        root = rotation.rotate(np.broadcast_to(back, (len(motion), 4)), motion.root - origin)
        quats = motion.rotations[:, :22].copy()
        quats[:, 0] = rotation.multiply(np.broadcast_to(back, quats[:, 0].shape), quats[:, 0])
        matrices = torch.as_tensor(rotation.quaternion_to_matrix(quats), dtype=torch.float32)
        pelvis = layout.six_from_matrix(matrices[:, 0])
        routes.append(torch.cat([torch.as_tensor(root, dtype=torch.float32), pelvis], -1))
        turns.append(matrices[:, 1:])
    return Predicted(torch.stack(routes).to(data.device), torch.stack(turns).to(data.device))


def places(data: LongTermData, windows: Windows) -> tuple[np.ndarray, np.ndarray]:
    """Return the origin (B, 3), metres, and the yaw (B,), radians, of the windows' frames in their rooms."""
    episode, first = data.windows[windows.index, 0], data.windows[windows.index, 1]
    frame = data.first[episode] + first
    origin = data.root[frame] * data.root.new_tensor([1.0, 0.0, 1.0])
    return origin.double().cpu().numpy(), data.yaw[frame].double().cpu().numpy()


def room_numbers(data: LongTermData, windows: Windows) -> np.ndarray:
    """Return the numbers (B,) of the windows' rooms in the corpus."""
    return data.numbers[data.rooms[data.windows[windows.index, 0]].cpu().numpy()]


class Rooms:
    """The rooms of a corpus with cached obstacles."""

    def __init__(self, corpus: Corpus) -> None:
        self.corpus = corpus
        self._known: dict[int, Obstacles] = {}

    def obstacles(self, number: int) -> Obstacles:
        """Return the obstacles of a room; those of the last room are cached."""
        if number not in self._known:
            self._known = {number: Obstacles(self.corpus.room(number).room.triangles)}
        return self._known[number]

    def measures(self, motion: Motion, number: int, human: Human) -> dict[str, float]:
        """Return non-collision and contact, percent, and the stance slide, cm/s, of a motion in a room."""
        depth, touching = collision.body_depth(motion, self.obstacles(number), FLOOR, human)
        found = feet.measures(motion, FLOOR, human)
        return {
            "non_collision": 100 * float((depth <= collision.ROUNDING).mean()),
            "contact": 100 * float(touching.any(1).mean()),
            "stance_slide": float(found.get("stance_slide_cm_s") or 0.0),
        }

    def optimised(self, motion: Motion, number: int, human: Human) -> Motion:
        """Return a motion after the optimisation of section 3.4, with the paper's weights."""
        triangles = self.corpus.room(number).room.triangles
        around = refinement.Surroundings(triangles, np.zeros(len(triangles)), FLOOR)
        return refinement.refine(motion, around, None, human, measured=False).motion
