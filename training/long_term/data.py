"""The packed corpus on a device, and random batches from it; frames of reference are those of layout.py."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from scipy.ndimage import gaussian_filter1d

from ...models.long_term import gait, layout
from ...models.long_term.pose_prior import PosePrior
from ...samp_addon import skeleton
from ...samp_addon.body import betas, hand_poses
from . import pack
from .body_model import COUNT, BodyModel

FPS = 30.0
CHUNK = 20_000
WALKING_SIZE = 0.3  # amplitude of the gait above which its phase counts
FLAT_FRAMES = 5.0  # frames, sigma with which a hand opens before it touches a surface
HAND_NOISE = 0.5  # standard deviation of the hand codes between episodes
LEFT, RIGHT = 4, 3  # columns of the feet in the contacts
_RIGHT_HAND, _LEFT_HAND = 1, 2


@dataclass(frozen=True)
class Windows:
    """A batch of windows of T frames, in the frame of their start.

    route: (B, T, 9), t and r. turns: (B, T, 21, 3, 3) local rotations. pose: (B, T, 32) p, or None without a prior.
    hands: (B, T, 24). betas: (B, 10). gait: (B, T, 2). total: (B,) radians by which the phase advances. feet: (B, T, 2)
    contacts of left and right foot. path: (B, 16, 2). index: rows of the pack's windows. mirrored: whether all are.
    """

    route: torch.Tensor
    turns: torch.Tensor
    pose: torch.Tensor | None
    hands: torch.Tensor
    betas: torch.Tensor
    gait: torch.Tensor
    total: torch.Tensor
    feet: torch.Tensor
    path: torch.Tensor
    index: torch.Tensor
    mirrored: bool


@dataclass(frozen=True)
class Frame:
    """B frames of reference in rooms. place: (B, 3) origin with y = 0. back: (B, 3, 3) rotation into the frame."""

    place: torch.Tensor
    back: torch.Tensor
    rooms: torch.Tensor

    def points(self, points: torch.Tensor) -> torch.Tensor:
        """Return points (B, N, 3) of the room in this frame."""
        return (points - self.place[:, None]) @ self.back.transpose(1, 2)


class LongTermData:
    """A pack on a device."""

    def __init__(self, raw: dict[str, np.ndarray], device: torch.device | str = "cpu") -> None:
        self.device = torch.device(device)
        put = lambda values, kind=torch.float32: torch.as_tensor(
            np.ascontiguousarray(values), dtype=kind, device=device
        )
        lengths = raw["lengths"].astype(np.int64)
        self.first = put(np.concatenate([[0], np.cumsum(lengths)[:-1]]), torch.int64)
        self.episode = torch.repeat_interleave(
            torch.arange(len(lengths), device=device), put(lengths, torch.int64)
        )
        self.root, self.quats = put(raw["root"]), put(raw["rotations"])
        self.contacts = put(raw["contacts"], torch.uint8)
        self.labels = put(raw["labels"], torch.int64)
        self.betas = put(betas.from_shapes(raw["shapes"]))
        self.rooms, self.numbers = put(raw["rooms"], torch.int64), np.asarray(raw["numbers"])
        self.points, self.normals = put(raw["points"]), put(raw["normals"])
        self.classes = put(raw["classes"], torch.int64)
        self.windows, self.paths = put(raw["windows"], torch.int64), put(raw["paths"])
        self.model = BodyModel(device)
        self.hands = put(_hands(raw))
        self.yaw, self.gait = self._gaits()
        self.pose: torch.Tensor | None = None
        self.rows = {n: (self.windows[:, 2] == n).nonzero()[:, 0] for n in pack.LENGTHS}
        self.rows = {n: rows for n, rows in self.rows.items() if len(rows)}
        self._swap = torch.as_tensor(skeleton.mirror_joints(), device=device)

    @classmethod
    def load(cls, path: Path, device: torch.device | str = "cpu") -> LongTermData:
        """Return the data of a pack file."""
        return cls(pack.read(path), device)

    def __len__(self) -> int:
        return len(self.root)

    @torch.no_grad()
    def encode(self, prior: PosePrior) -> None:
        """Compute the prior's 32 numbers of all frames."""
        parts = [prior.encode(matrices(self.quats[k : k + CHUNK, 1:]))[0] for k in range(0, len(self), CHUNK)]
        self.pose = torch.cat(parts)

    def draw_windows(self, length: int, count: int, mirror: bool = True) -> Windows:
        """Return random windows of a length in pack.LENGTHS; half of the batches are mirrored."""
        rows = self.rows[length]
        chosen = rows[torch.randint(len(rows), (count,), device=self.device)]
        return self.window_batch(chosen, mirror and bool(torch.rand(()) < 0.5))

    def window_batch(self, rows: torch.Tensor, mirrored: bool = False) -> Windows:
        """Return windows by their rows (B,), all of the same length."""
        length = int(self.windows[rows[0], 2])
        episode, first = self.windows[rows, 0], self.windows[rows, 1]
        frames = (self.first[episode] + first)[:, None] + torch.arange(length, device=self.device)
        quats, root, hands, step = (
            self.quats[frames],
            self.root[frames],
            self.hands[frames],
            self.gait[frames],
        )
        feet, path, yaw = (
            self.contacts[frames][..., [LEFT, RIGHT]].float(),
            self.paths[rows],
            self.yaw[frames[:, 0]],
        )
        pose = None if self.pose is None or mirrored else self.pose[frames]
        if mirrored:
            quats, root, hands, yaw = self.mirrored(quats), reflected(root), swapped_hands(hands), -yaw
            feet, path, step = feet.flip(-1), path * path.new_tensor([-1.0, 1.0]), -step
        origin = root[:, 0] * root.new_tensor([1.0, 0.0, 1.0])
        back = layout.about_y(-yaw)
        place = (root - origin[:, None]) @ back.transpose(1, 2)
        turned = matrices(quats)
        pelvis = back[:, None] @ turned[:, :, 0]
        line = torch.stack([path[..., 0], torch.zeros_like(path[..., 0]), path[..., 1]], -1) - origin[:, None]
        line = (line @ back.transpose(1, 2))[..., [0, 2]]
        route = torch.cat([place, layout.six_from_matrix(pelvis)], -1)
        return Windows(
            route, turned[:, :, 1:], pose, hands, self.betas[episode], step, _total(step), feet, line, rows, mirrored
        )  # fmt: skip

    def cloud(
        self, windows: Windows, count: int, radius: float = 2.0, generator: torch.Generator | None = None
    ) -> torch.Tensor:
        """Return points (B, count, 3) within a radius of the start or the goal, in the start's frame."""
        episode, first = self.windows[windows.index, 0], self.windows[windows.index, 1]
        frame = self.first[episode] + first
        ends = torch.stack([self.root[frame], self.root[frame + windows.route.shape[1] - 1]], 1)
        seen = Frame(
            ends[:, 0] * ends.new_tensor([1.0, 0.0, 1.0]),
            layout.about_y(-self.yaw[frame]),
            self.rooms[episode],
        )
        chosen = self.near(seen.rooms, ends, count, radius, generator)
        points = seen.points(torch.gather(self.points[seen.rooms], 1, chosen[..., None].expand(-1, -1, 3)))
        return reflected(points) if windows.mirrored else points

    def near(
        self, rooms: torch.Tensor, places: torch.Tensor, count: int, radius: float,
        generator: torch.Generator | None = None, tall: float = 2.2,
    ) -> torch.Tensor:  # fmt: skip
        """Return indices (B, count) of random points of rooms within a radius of any of places (B, K, 3).

        Where there are too few, the nearest other points are added. tall: greatest height of the points, metres.
        """
        points = self.points[rooms]
        away = (points[:, :, None, [0, 2]] - places[:, None, :, [0, 2]]).norm(dim=-1).amin(2)
        away = away + 10 * (points[..., 1] > tall)
        key = torch.rand(away.shape, device=self.device, generator=generator) - 1
        return torch.where(away < radius, key + 1, -away).topk(count, dim=1).indices

    def mirrored(self, quats: torch.Tensor) -> torch.Tensor:
        """Return mirrored poses (..., 22, 4)."""
        return quats[..., self._swap, :] * quats.new_tensor([1.0, 1.0, -1.0, -1.0])

    @torch.no_grad()
    def _gaits(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the yaw (N,) and the gait (N, 2) of all frames."""
        yaws, phases = [], []
        for k in range(0, len(self), CHUNK):
            turned = matrices(self.quats[k : k + CHUNK])
            rest = self.model.rest_joints(self.betas[self.episode[k : k + CHUNK]])
            joints = self.model.joints(self.root[k : k + CHUNK], turned, rest)[0]
            yaws.append(layout.yaw_of(turned[:, 0]))
            phases.append(gait.phase_of(joints, yaws[-1]))
        speed = torch.zeros(len(self), device=self.device)
        speed[1:] = (self.root[1:] - self.root[:-1])[:, [0, 2]].norm(dim=-1) * FPS
        speed[self.first] = speed[(self.first + 1).clamp(max=len(self) - 1)]
        size = 1 - torch.exp(-(speed / gait.WALKING).square())
        return torch.cat(yaws), torch.nn.functional.normalize(torch.cat(phases), dim=-1) * size[:, None]


def matrices(quats: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (..., 3, 3) of quaternions w, x, y, z (..., 4)."""
    w, x, y, z = torch.nn.functional.normalize(quats, dim=-1).unbind(-1)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return torch.stack([torch.stack(row, -1) for row in rows], -2)


def reflected(points: torch.Tensor) -> torch.Tensor:
    """Return mirrored points (..., 3), with x negated."""
    return points * points.new_tensor([-1.0, 1.0, 1.0])


def swapped_hands(codes: torch.Tensor) -> torch.Tensor:
    """Return hand codes (..., 24) with left and right exchanged."""
    return torch.cat([codes[..., hand_poses.EACH :], codes[..., : hand_poses.EACH]], -1)


def _total(step: torch.Tensor) -> torch.Tensor:
    """Return the radians (B,) by which the phase of gaits (B, T, 2) advances while walking."""
    walks = (step.norm(dim=-1) > WALKING_SIZE).float()
    turns = torch.diff(gait.unwrapped(step), dim=1) * walks[:, 1:] * walks[:, :-1]
    return turns.sum(1)


def _hands(raw: dict[str, np.ndarray]) -> np.ndarray:
    """Return synthetic hand codes (N, 24): relaxed, with a variation for each episode, flat on surfaces."""
    rng = np.random.default_rng(5)
    relaxed, flat = hand_poses.code("relaxed"), hand_poses.code("flat")
    parts, first = [], 0
    for length in raw["lengths"]:
        rows = slice(first, first + int(length))
        own = relaxed + rng.normal(0, HAND_NOISE, hand_poses.COUNT)
        touching = raw["contacts"][rows][:, [_LEFT_HAND, _RIGHT_HAND]].astype(float)
        touching = gaussian_filter1d(touching, FLAT_FRAMES, axis=0, mode="nearest")
        share = np.repeat(touching, hand_poses.EACH, axis=1)
        parts.append(own + share * (flat - own))
        first += int(length)
    return np.concatenate(parts).astype(np.float32)


assert COUNT == layout.JOINTS + 1
