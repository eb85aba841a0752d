"""A training set resident on a device: state and target of every frame, furniture, and start frames of rollouts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch

from .....models import state
from .....samp_addon import skeleton
from .....samp_addon.scene.voxels import RESOLUTION
from .....samp_addon.vocabulary import ACTIONS, POSTURE_NAMES, POSTURES
from . import compact, drift, rarity, styles
from .features import Encoder

SHARES = {"sit": 0.40, "lie": 0.17, "walk": 0.19, "stroll": 0.08, "run": 0.10, "idle": 0.06}
BED_HALF = (
    0.5  # metres subtracted from the distance to a lying place, because the edge of the bed comes first
)
UNKNOWN_BEFORE, UNKNOWN_AFTER = 25, 30  # frames next to an open end that are not learnt
BOTH_SIDES = [0, 2, 1, 4, 3]  # order of the contacts with right and left exchanged


@dataclass
class Frames:
    """N frames of S sequences with P pieces of furniture, all on one device.

    states, targets: (N, 647) half precision. roots: (N, 3). sequence: (N,). usable, seated_goal, lying_goal: (N,).
    goal: (N, 2) x and z of the goal in force. pieces (S, K), -1 for none, their placements (S, K, 3), and
    choices (S,), the count of pieces. postures (S, 9) of the rests, in the order of POSTURE_NAMES.
    centres (P, 512, 3), occupancy (P, 512). starts: (M,) frames in which a rollout may start; until: (M,) their
    cumulative probabilities. goal_grid: whether the grids are drawn around the goals. mirrored: whether the second half
    of the sequences are mirror images of the first.
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
    postures: torch.Tensor
    actions: torch.Tensor
    styles: torch.Tensor
    centres: torch.Tensor
    occupancy: torch.Tensor
    starts: torch.Tensor
    until: torch.Tensor
    goal_grid: bool
    mirrored: bool = False

    def __len__(self) -> int:
        return len(self.roots)

    @property
    def device(self) -> torch.device:
        return self.roots.device

    def without_augmentation(self) -> Frames:
        """Return the captures alone: no mirror images, and of each capture's furniture only the first piece."""
        count = len(self.choices) // 2 if self.mirrored else len(self.choices)
        own = self.sequence[self.starts] < count
        share = torch.diff(self.until, prepend=self.until.new_zeros(1))[own]
        return replace(
            self, choices=torch.ones_like(self.choices), starts=self.starts[own],
            until=share.cumsum(0) / share.sum(),
        )  # fmt: skip

    def sample_starts(self, chance: torch.Tensor) -> torch.Tensor:
        """Return start frames (B,), balanced over the kinds. chance: (B,) uniform in 0 to 1, double precision."""
        return self.starts[torch.searchsorted(self.until, chance).clamp(max=len(self.starts) - 1)]

    def sample_pieces(self, frames: torch.Tensor, chance: torch.Tensor) -> torch.Tensor:
        """Return a column (B,) of ``pieces`` for the sequences of frames (B,). chance: (B,) uniform in 0 to 1."""
        among = self.choices[self.sequence[frames]]
        return (chance * among).long().clamp(max=self.pieces.shape[1] - 1)

    def goal_distance(self, frames: torch.Tensor, roots: torch.Tensor) -> torch.Tensor:
        """Return horizontal distances (B,), metres, from roots (B, 3) to the goals or edges of beds of frames (B,)."""
        return (roots[:, :2] - self.goal[frames]).norm(dim=-1) - BED_HALF * self.lying_goal[frames]

    def return_lengths(self, frames: torch.Tensor) -> torch.Tensor:
        """Return the lengths of path (B, 1) over which drifts from frames (B,) decay; see drift.py."""
        return drift.return_lengths(self.goal_distance(frames, self.roots[frames]), self.seated_goal[frames])

    def sample_styles(self, action: int, count: int) -> tuple[torch.Tensor, torch.Tensor]:
        """Return styles (K, 16) and postures (K, 9) of random sequences of an action; none where there are none."""
        fits = torch.nonzero(self.actions == action)[:, 0]
        chosen = fits[torch.randint(len(fits), (count,), device=self.device)] if len(fits) else fits
        return self.styles[chosen], self.postures[chosen]

    def object_features(
        self, frames: torch.Tensor, roots: torch.Tensor, choice: torch.Tensor, shown: torch.Tensor
    ) -> torch.Tensor:
        """Return the features (B, 2048 + 9) of the pieces ``choice`` (B,) of frames (B,) in the frames of roots (B, 3).

        The last 9 are the postures of the rests, zero except for the rows in which ``shown`` (B,) is set.
        """
        number = self.sequence[frames]
        piece, place = self.pieces[number, choice], self.placements[number, choice]
        centres = self.centres[piece.clamp(min=0)]
        turned = state.turn3(centres, place[:, 2:].expand(centres.shape[:2]))
        world = turned + torch.stack([place[:, 0], torch.zeros_like(place[:, 0]), place[:, 1]], -1)[:, None]
        features = state.interaction_features(world, self.occupancy[piece.clamp(min=0)], roots)
        seated = self.seated_goal[frames]
        postures = self.postures[number] * (seated & shown)[:, None]
        return torch.cat([features * ((piece >= 0) & seated)[:, None], postures], -1)

    def posture_shares(self, rows: int) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the commonest combinations of postures (rows, 9), zeros and ones, and their shares (rows,).

        The shares are of sits and of lies, each summing to one; rows that are not needed are zero.
        """
        known = self.postures[self.postures.sum(-1) > 0] >= 0.5
        combined, counts = torch.unique(known, dim=0, return_counts=True)
        shares = counts.double()
        sits = combined[:, : len(POSTURES["sit"])].any(-1)
        lies = combined[:, len(POSTURES["sit"]) :].any(-1)
        for kind in (sits & ~lies, lies):
            shares[kind] /= shares[kind].sum().clamp(min=1)
        shares[~(sits | lies)] = 0
        order = torch.argsort(shares, descending=True)[:rows]
        out = torch.zeros(rows, len(POSTURE_NAMES)), torch.zeros(rows)
        out[0][: len(order)], out[1][: len(order)] = (
            combined[order].float().cpu(),
            shares[order].float().cpu(),
        )
        return out


def load(path: Path, device: str, window: int) -> Frames:
    """Load the output of prepare.py or its compact form. window: usable frames that must follow a start frame."""
    return load_with_starts(path, device, window)[0]


def load_with_starts(path: Path, device: str, window: int) -> tuple[Frames, dict[str, torch.Tensor]]:
    """Load a training set, and the start poses if the file contains them: start_heights and start_rotations."""
    raw = compact.read(path) if path.suffix == ".bin" else dict(np.load(path))
    starts = {
        name: torch.as_tensor(raw.pop(name)) for name in ("start_heights", "start_rotations") if name in raw
    }
    return build(raw, device, window), starts


def build(raw: dict[str, np.ndarray], device: str, window: int) -> Frames:
    """Build a training set from arrays (save in training/composition/sequence.py). Adds mirror images if requested."""
    raw = with_defaults(raw)
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
    action, actions = tensor("goal_action", torch.int64), _actions(raw["kinds"])
    on = lambda values: torch.as_tensor(values, device=device)
    return Frames(
        states, targets, encoder.roots, repeat(np.arange(len(lengths))), on(usable), action >= 3, action == 4,
        tensor("goal")[:, [0, 2]].clone(), on(pieces).long(), on(places).float(),
        on((pieces >= 0).sum(1).clip(1)), tensor("postures"), on(actions), styles.measure(states, lengths, actions),
        tensor("piece_centres"), tensor("piece_occupancy"), on(starts), on(until),
        bool(raw["goal_grid"]), bool(raw["mirrored"]),
    )  # fmt: skip


def _actions(kinds: np.ndarray) -> np.ndarray:
    """Return the indices (S,) of the actions of sequences of kinds (S,); strolls are walks."""
    return np.array([ACTIONS.index({"stroll": "walk"}.get(str(kind), str(kind))) for kind in kinds])


def with_defaults(raw: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the arrays, with defaults for those that older files lack."""
    count = len(raw["lengths"])
    return {
        "weights": np.ones(count, np.float32),
        "more_pieces": np.full((count, 0), -1),
        "more_placements": np.zeros((count, 0, 3), np.float32),
        "mirrored": np.array(False),
        "goal_grid": np.array(False),
        "postures": np.zeros((count, len(POSTURE_NAMES)), np.float32),
    } | raw


def _with_mirror_images(raw: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the arrays with a copy of every sequence, mirrored at the plane x = 0."""
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
    # Cells are in the order of the box's axes, so the x axis of the mirrored box is reversed.
    other["piece_centres"] = (raw["piece_centres"].reshape(*grid, 3)[:, ::-1] * across).reshape(count, -1, 3)
    other["piece_occupancy"] = raw["piece_occupancy"].reshape(grid)[:, ::-1].reshape(count, -1)
    return {name: values if name in ("mirrored", "goal_grid") else np.concatenate([values, other[name]])
            for name, values in raw.items()}  # fmt: skip


def _usable(raw: dict[str, np.ndarray]) -> np.ndarray:
    """Return flags (N,) of frames without pops whose states contain only known past and future."""
    usable = ~raw["bad"]
    ends = np.cumsum(raw["lengths"])
    for begin, end, (open_start, open_end) in zip(ends - raw["lengths"], ends, raw["open_ends"], strict=True):
        usable[begin : begin + UNKNOWN_BEFORE * int(open_start)] = False
        usable[max(begin, end - 1 - UNKNOWN_AFTER * int(open_end)) : end] = False
    return usable


def _starts(raw: dict[str, np.ndarray], usable: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Return start frames (M,) and their cumulative probabilities (M,).

    From a start frame, ``window`` usable frames of one sequence follow. The kinds have the probabilities SHARES;
    within a kind, frames are weighted by their sequences, and those that lead to rare postures more (rarity.py).
    """
    sequence = np.repeat(np.arange(len(raw["lengths"])), raw["lengths"])
    total = np.concatenate([[0], np.cumsum(usable)])
    at = np.arange(max(len(usable) - window, 0))
    whole = (total[at + window] - total[at] == window) & (sequence[at] == sequence[at + window])
    at = at[whole]
    kinds = raw["kinds"][sequence[at]]
    rare = rarity.weights(raw["postures"], raw["kinds"])
    chance = (raw["weights"] * rare)[sequence[at]].astype(np.float64)
    for kind in np.unique(kinds):
        of_kind = kinds == kind
        chance[of_kind] *= SHARES.get(str(kind), 0.0) / chance[of_kind].sum()
    return at, np.cumsum(chance) / chance.sum()
