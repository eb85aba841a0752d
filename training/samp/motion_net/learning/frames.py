"""A training set resident on a device: every frame's state and target, its furniture, and where rollouts may start."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from .....models import state
from .....samp_addon import skeleton
from .....samp_addon.scene.voxels import RESOLUTION
from . import compact
from .features import Encoder

SHARES = {"sit": 0.40, "lie": 0.17, "walk": 0.19, "stroll": 0.08, "run": 0.10, "idle": 0.06}
BED_HALF = 0.5  # metres from a lying place that count as reached: the edge comes first
UNKNOWN_BEFORE, UNKNOWN_AFTER = 25, 30  # frames next to an open end that nobody may learn from
BOTH_SIDES = [0, 2, 1, 4, 3]  # contacts with right and left exchanged


@dataclass
class Frames:
    """N frames of S sequences with P pieces, all on one device.

    states, targets: (N, 647) half precision. roots: (N, 3). sequence: (N,). usable, seated_goal, lying_goal: (N,).
    goal: (N, 2) x and z of the goal in force. pieces (S, K), -1 for none, their placements (S, K, 3), choices (S,)
    how many of them there are. centres (P, 512, 3), occupancy (P, 512). starts: (M,) frames in which a rollout may
    begin; until: (M,) how likely it begins in this one or one before.
    """

    states: torch.Tensor
    targets: torch.Tensor
    roots: torch.Tensor
    sequence: torch.Tensor
    usable: torch.Tensor
    seated_goal: torch.Tensor
    lying_goal: torch.Tensor
    goal: torch.Tensor
    pieces: torch.Tensor
    placements: torch.Tensor
    choices: torch.Tensor
    centres: torch.Tensor
    occupancy: torch.Tensor
    starts: torch.Tensor
    until: torch.Tensor

    def __len__(self) -> int:
        return len(self.roots)

    @property
    def device(self) -> torch.device:
        return self.roots.device

    def starts_of(self, chance: torch.Tensor) -> torch.Tensor:
        """First frames (B,) of rollouts, balanced over the kinds. chance: (B,) between 0 and 1, double precision."""
        return self.starts[torch.searchsorted(self.until, chance).clamp(max=len(self.starts) - 1)]

    def pieces_of(self, frames: torch.Tensor, chance: torch.Tensor) -> torch.Tensor:
        """One of the pieces (B,), as a column of ``pieces``, that fit the sequences of frames (B,)."""
        among = self.choices[self.sequence[frames]]
        return (chance * among).long().clamp(max=self.pieces.shape[1] - 1)

    def goal_distance(self, frames: torch.Tensor, roots: torch.Tensor) -> torch.Tensor:
        """Metres (B,) on the floor from roots (B, 3) to the goals of frames (B,), or to the edge of a bed."""
        return (roots[:, :2] - self.goal[frames]).norm(dim=-1) - BED_HALF * self.lying_goal[frames]

    def object_features(
        self, frames: torch.Tensor, roots: torch.Tensor, choice: torch.Tensor
    ) -> torch.Tensor:
        """Features (B, 2048) of the pieces ``choice`` (B,) of frames (B,), seen from roots (B, 3)."""
        number = self.sequence[frames]
        piece, place = self.pieces[number, choice], self.placements[number, choice]
        centres = self.centres[piece.clamp(min=0)]
        turned = state.turn3(centres, place[:, 2:].expand(centres.shape[:2]))
        world = turned + torch.stack([place[:, 0], torch.zeros_like(place[:, 0]), place[:, 1]], -1)[:, None]
        features = state.interaction_features(world, self.occupancy[piece.clamp(min=0)], roots)
        return features * ((piece >= 0) & self.seated_goal[frames])[:, None]


def load(path: Path, device: str, window: int) -> Frames:
    """The set of prepare.py, or its compact form. window: frames that a rollout has to have before it."""
    return load_with_starts(path, device, window)[0]


def load_with_starts(path: Path, device: str, window: int) -> tuple[Frames, dict[str, torch.Tensor]]:
    """The set, and the poses that takes start in, where the file holds them: start_heights and start_rotations."""
    raw = compact.read(path) if path.suffix == ".bin" else dict(np.load(path))
    starts = {
        name: torch.as_tensor(raw.pop(name)) for name in ("start_heights", "start_rotations") if name in raw
    }
    return build(raw, device, window), starts


def build(raw: dict[str, np.ndarray], device: str, window: int) -> Frames:
    """The set of these arrays (training/composition/sequence.py, save), mirror images added where they are wanted."""
    raw = complete(raw)
    if raw["mirrored"]:
        raw = _with_mirror_images(raw)
    tensor = lambda name, dtype=torch.float32: torch.as_tensor(raw[name], device=device).to(dtype)
    lengths = raw["lengths"]
    ends = np.cumsum(lengths)
    repeat = lambda values: torch.as_tensor(np.repeat(values, lengths), device=device)
    first, last = repeat(ends - lengths), repeat(ends - 1)
    encoder = Encoder(
        tensor("root"), tensor("rotations", torch.int16), tensor("actions", torch.float16),
        tensor("contacts", torch.float16), tensor("goal"), tensor("goal_action", torch.int64), first, last,
    )  # fmt: skip
    states, targets = encoder.encode()
    usable = _usable(raw)
    starts, until = _starts(raw, usable, window)
    pieces = np.column_stack([raw["pieces"], raw["more_pieces"]])
    places = np.concatenate([raw["placements"][:, None], raw["more_placements"]], 1)
    action = tensor("goal_action", torch.int64)
    on = lambda values: torch.as_tensor(values, device=device)
    return Frames(
        states, targets, encoder.roots, repeat(np.arange(len(lengths))), on(usable), action >= 3, action == 4,
        tensor("goal")[:, [0, 2]].clone(), on(pieces).long(), on(places).float(),
        on((pieces >= 0).sum(1).clip(1)), tensor("piece_centres"), tensor("piece_occupancy"), on(starts), on(until),
    )  # fmt: skip


def complete(raw: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays with those that older files have not."""
    count = len(raw["lengths"])
    return {
        "weights": np.ones(count, np.float32),
        "more_pieces": np.full((count, 0), -1),
        "more_placements": np.zeros((count, 0, 3), np.float32),
        "mirrored": np.array(False),
    } | raw


def _with_mirror_images(raw: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Every sequence twice, the second time with left and right exchanged, across the plane x = 0."""
    other = dict(raw)
    across = np.array([-1, 1, 1], np.float32)
    other["root"] = raw["root"] * across
    other["rotations"] = raw["rotations"][:, skeleton.mirror_joints()] * np.array([1, 1, -1, -1], np.int16)
    other["contacts"] = raw["contacts"][:, BOTH_SIDES]
    other["goal"] = raw["goal"] * np.tile(across, 2)
    for name in ("placements", "more_placements"):
        other[name] = raw[name] * np.array([-1, 1, -1], np.float32)
    count = len(raw["piece_centres"])
    for name in ("pieces", "more_pieces"):
        other[name] = np.where(raw[name] < 0, -1, raw[name] + count)
    grid = (count, RESOLUTION, RESOLUTION, RESOLUTION)
    # Cells are told in the order of the box's axes: the mirrored box is read from its other end.
    other["piece_centres"] = (raw["piece_centres"].reshape(*grid, 3)[:, ::-1] * across).reshape(count, -1, 3)
    other["piece_occupancy"] = raw["piece_occupancy"].reshape(grid)[:, ::-1].reshape(count, -1)
    return {name: values if name == "mirrored" else np.concatenate([values, other[name]])
            for name, values in raw.items()}  # fmt: skip


def _usable(raw: dict[str, np.ndarray]) -> np.ndarray:
    """Flags (N,) of frames to learn from: no pops, and all of the past and future that their states tell of."""
    usable = ~raw["bad"]
    ends = np.cumsum(raw["lengths"])
    for begin, end, (open_start, open_end) in zip(ends - raw["lengths"], ends, raw["open_ends"], strict=True):
        usable[begin : begin + UNKNOWN_BEFORE * int(open_start)] = False
        usable[max(begin, end - 1 - UNKNOWN_AFTER * int(open_end)) : end] = False
    return usable


def _starts(raw: dict[str, np.ndarray], usable: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Frames (M,) from which ``window`` frames stay in usable frames of one sequence, and how likely a rollout begins
    in each of them or before (M,): shared out among the kinds, within a kind by the sequences' weights."""
    sequence = np.repeat(np.arange(len(raw["lengths"])), raw["lengths"])
    total = np.concatenate([[0], np.cumsum(usable)])
    at = np.arange(max(len(usable) - window, 0))
    whole = (total[at + window] - total[at] == window) & (sequence[at] == sequence[at + window])
    at = at[whole]
    kinds = raw["kinds"][sequence[at]]
    chance = raw["weights"][sequence[at]].astype(np.float64)
    for kind in np.unique(kinds):
        of_kind = kinds == kind
        chance[of_kind] *= SHARES.get(str(kind), 0.0) / chance[of_kind].sum()
    return at, np.cumsum(chance) / chance.sum()
