"""Orientations of captured bodies in each action: their facing, and the table used to draw sub-goal bodies.

Network frame, metres.
"""

from __future__ import annotations

import torch

from ....models.long_term import layout
from ....models.long_term.sub_goal_net import ACTIONS, TURNS
from ...rooms.episodes.bank import LABELS
from ..data import LongTermData, matrices

LABELLED = {"idle": ("idle", "shift", "walk", "run"), "sit": ("sit",), "lie": ("lie",)}
"""Labels of the frames of each action; transitions belong to none."""
UNDER, LEVEL = (
    0.2,
    0.7,
)  # of the pelvis' support: radius (m) around the pelvis, and least vertical component of the normal
MOST_RISE = 0.15  # largest deviation (m) from the median height; larger ones are errors of the cloud
SEED = 7


def actions(data: LongTermData, rows: torch.Tensor) -> torch.Tensor:
    """Return the one-hot actions (B, 3) of frames (B,), zeros for none."""
    labels = data.labels[rows]
    return torch.stack([torch.isin(labels, _numbers(name, labels)) for name in ACTIONS], -1).float()


def facing(data: LongTermData, rows: torch.Tensor) -> torch.Tensor:
    """Return the yaw (B,), radians, of frames (B,); for lying bodies from the head to the feet."""
    lying = torch.isin(data.labels[rows], _numbers("lie", data.labels))
    return torch.where(lying, layout.lying_yaw_of(matrices(data.quats[rows, 0])), data.yaw[rows])


def tilt(vectors: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (B, 3, 3) of small rotation vectors (B, 3)."""
    half = vectors / 2
    return matrices(torch.cat([torch.ones_like(half[:, :1]), half], -1))


def table(data: LongTermData) -> torch.Tensor:
    """Return the table (3, TURNS, 7) of random bodies: r facing +Z, and the pelvis' rise over its median height.

    Half of the bodies are mirrored. Actions without frames get upright bodies.
    """
    generator = torch.Generator(device=data.device).manual_seed(SEED)
    draw = lambda most: torch.randint(most, (TURNS,), device=data.device, generator=generator)
    upright = torch.tensor([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], device=data.device)
    found = upright.repeat(len(ACTIONS), TURNS, 1)
    for number, name in enumerate(ACTIONS):
        known = torch.isin(data.labels, _numbers(name, data.labels)).nonzero()[:, 0]
        if not len(known):
            continue
        rows = known[draw(len(known))]
        quats, yaw = data.quats[rows], facing(data, rows)
        half = TURNS // 2
        pelvis = torch.cat([quats[:half, 0], data.mirrored(quats[half:])[:, 0]])
        yaw = torch.cat([yaw[:half], -yaw[half:]])
        found[number, :, :-1] = layout.six_from_matrix(layout.about_y(-yaw) @ matrices(pelvis))
        if name != "idle":
            found[number, :, -1] = _rises(data, rows)
    return found


def _rises(data: LongTermData, rows: torch.Tensor) -> torch.Tensor:
    """Return the pelvis' height over its support (B,), metres, relative to the median; 0 where it is unknown."""
    root, rooms = data.root[rows], data.rooms[data.episode[rows]]
    over = torch.full((len(rows),), torch.nan, device=data.device)
    for k, room in enumerate(rooms.tolist()):
        points, normals = data.points[room], data.normals[room]
        near = (points[:, [0, 2]] - root[k, [0, 2]]).norm(dim=-1) < UNDER
        below = near & (normals[:, 1] > LEVEL) & (points[:, 1] < root[k, 1])
        if bool(below.any()):
            over[k] = root[k, 1] - points[below, 1].max()
    rise = over - over.nanmedian()
    return torch.where(rise.abs() < MOST_RISE, rise, torch.zeros_like(rise))


def _numbers(name: str, like: torch.Tensor) -> torch.Tensor:
    return torch.tensor([LABELS.index(label) for label in LABELLED[name]], device=like.device)
