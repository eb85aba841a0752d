"""The data set on a device: batches of starts, true motion and the scene, in the networks' frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import torch

from ....models.scene_gan import constants, height_map, kinematics, scene_encoder
from ....models.scene_gan.projection import Motions
from ....models.scene_gan.start import Start
from .units import HEIGHT_CELL, HEIGHT_UNIT, IDLE, NOTHING, ROOT_UNIT

_MIRRORED = (0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10, 12, 14, 13, 15, 17, 16, 19, 18, 21, 20)
MOVING = 0.4
"""Metres of the pelvis in a window from which a body walks; in nine of ten windows it travels less than 0.8."""
SMALL = (
    "root", "rotations", "labels", "body", "rest", "pairs", "lens", "extrinsics", "heights", "corners",
    "room_of_picture",
)  # fmt: skip
MAPS = ("colour", "depth", "classes")


@dataclass(frozen=True)
class Batch:
    """B windows with their scene. motions: captured. pairs: (B,) numbers of the pairs. mirrored: (B,) flags."""

    start: Start
    motions: Motions
    pairs: torch.Tensor
    mirrored: torch.Tensor


class Dataset:
    """The arrays of one split. device: of all results. Pictures stay memory-mapped on the CPU unless ``resident``."""

    def __init__(
        self, arrays: Mapping[str, np.ndarray], device: torch.device | str = "cpu", resident: bool = False
    ) -> None:
        self.device = torch.device(device)
        self.small = {
            name: torch.as_tensor(np.array(arrays[name])).to(self.device) for name in SMALL if name in arrays
        }
        self.maps = {name: arrays[name] for name in MAPS if name in arrays}
        if resident:
            self.maps = {
                name: torch.as_tensor(_signed(np.array(values))).to(self.device)
                for name, values in self.maps.items()
            }
        self.width = self.maps["depth"].shape[2]
        forward = self.small["extrinsics"][:, 2, :3]
        self.yaw = torch.atan2(forward[:, 0], forward[:, 2])
        turn = self.small["extrinsics"][:, :3, :3]
        self.eye = -(turn.transpose(1, 2) @ self.small["extrinsics"][:, :3, 3:])[..., 0]
        self.axes = _yawed_axes(self.yaw)
        self.camera = turn @ self.axes

    def __len__(self) -> int:
        return len(self.small["pairs"])

    def keep(self, count: int, seed: int = 0) -> None:
        """Keep ``count`` random pairs, with as many different windows as there are."""
        pairs = self.small["pairs"].cpu()
        order = torch.randperm(len(pairs), generator=torch.Generator().manual_seed(seed))
        windows = pairs[order, 1].numpy()
        repeats = np.ones(len(windows), bool)
        repeats[np.unique(windows, return_index=True)[1]] = False
        chosen = order[np.argsort(repeats, kind="stable")[:count]]
        self.small["pairs"] = pairs[chosen.sort().values].to(self.device)

    @cached_property
    def moving(self) -> torch.Tensor:
        """The pairs (M,) whose bodies travel at least MOVING."""
        root = self.small["root"][self.small["pairs"][:, 1].long()][:, [1, -1]].float() * ROOT_UNIT
        return torch.nonzero((root[:, 1] - root[:, 0])[:, [0, 2]].norm(dim=-1) >= MOVING)[:, 0]

    def sample(self, count: int, generator: torch.Generator | None, moving: float = 0.0) -> Batch:
        """Return a random batch, with half of the windows mirrored on average.

        generator: None for the device's own. moving: share of the batch that is drawn from the bodies that travel.
        """
        where = self.device if generator is None else generator.device
        pairs = torch.randint(len(self), (count,), generator=generator, device=where)
        chosen = round(moving * count)
        if chosen and len(self.moving):
            rows = torch.randint(len(self.moving), (chosen,), generator=generator, device=where)
            pairs[:chosen] = self.moving[rows.to(self.device)].to(where)
        mirrored = torch.rand(count, generator=generator, device=where) < 0.5
        return self.batch(pairs.to(self.device), mirrored.to(self.device))

    def batch(self, pairs: torch.Tensor, mirrored: torch.Tensor | None = None) -> Batch:
        """Return the windows of some pairs (B,). mirrored: (B,) flags."""
        if mirrored is None:
            mirrored = torch.zeros(len(pairs), dtype=torch.bool, device=self.device)
        picture, window = self.small["pairs"][pairs].long().unbind(-1)
        root = self.small["root"][window].float() * ROOT_UNIT
        quats = self.small["rotations"][window].float()
        rotations = kinematics.quaternion_matrices(quats / quats.norm(dim=-1, keepdim=True).clamp(min=1e-6))
        rest = self.small["rest"][self.small["body"][window].long()]
        axes = self.axes[picture]
        height = root[:, 1, 1]
        root = (root - self.eye[picture][:, None]) @ axes
        pelvis = axes.transpose(1, 2)[:, None] @ rotations[:, :, 0]
        rotations = torch.cat([pelvis[:, :, None], rotations[:, :, 1:]], dim=2)
        camera, lens = self.camera[picture], self.small["lens"][picture]
        root, rotations, rest, camera, lens = _mirrored(root, rotations, rest, camera, lens, mirrored)
        six = kinematics.six_numbers(rotations)
        positions = kinematics.joint_positions(rotations, rest[:, None])
        camera = torch.cat([camera, torch.zeros_like(camera[..., :1])], dim=-1)
        start = Start(
            six[:, 1],
            root[:, 1],
            rest,
            positions[:, 1] - positions[:, 0],
            root[:, 1] - root[:, 0],
            height,
            camera,
            lens,
        )
        shift = self._shift(start)
        # The picture is centred on the start (section 3), and the principal point moves with it.
        moved = Start(
            **{**vars(start), "lens": torch.cat([lens[:, :1], lens[:, 1:] + shift / self.width], -1)}
        )
        return Batch(moved, Motions(root[:, 1:], six[:, 1:], positions[:, 1:]), pairs, mirrored)

    def labels(self, pairs: torch.Tensor) -> torch.Tensor:
        """Return the labels (B, 65) of windows' frames."""
        return self.small["labels"][self.small["pairs"][pairs, 1].long()][:, 1:]

    def standing(self, count: int, label: int = IDLE) -> torch.Tensor:
        """Return rotations (count, 22, 6) of bodies that stand still, turned to face +Z.

        label: of standing. The slowest upright starts are used. Raise ValueError where there are none.
        """
        found = []
        for first in range(0, len(self), 512):
            pairs = torch.arange(first, min(first + 512, len(self)), device=self.device)
            batch = self.batch(pairs[self.labels(pairs)[:, 0] == label])
            start = batch.start
            pace = start.joint_velocity.norm(dim=-1).mean(-1) + start.root_velocity.norm(dim=-1)
            upright = start.height > 0.97 * -start.rest[:, :, 1].min(1).values
            found.append((pace[upright], start.six[upright], start.positions[upright]))
        pace, six, joints = (torch.cat(parts) for parts in zip(*found, strict=True))
        if not len(pace):
            raise ValueError("the data set contains no standing body")
        rows = pace.argsort()[: 4 * count][torch.arange(count) * min(4 * count, len(pace)) // count]
        across = joints[rows, 1] - joints[rows, 2]
        turn = _yawed_axes(torch.atan2(-across[:, 2], across[:, 0]))
        matrices = kinematics.matrices(six[rows])
        matrices[:, 0] = turn.transpose(1, 2) @ matrices[:, 0]
        return kinematics.six_numbers(matrices)

    def _shift(self, start: Start) -> torch.Tensor:
        """Return the shift in whole pixels (B, 2), x and y, that centres the pictures on the pelvis."""
        from ....models.scene_gan.projection import ASPECT, project

        place = project(start.root[:, None], start)[:, 0]
        middle = constants.numbers((0.5, ASPECT / 2), self.device)
        return torch.round((middle - place) * self.width)

    def pictures(self, name: str, batch: Batch, step: int = 1) -> torch.Tensor:
        """Return a map (B, H, W, ...) of a batch, shifted and mirrored like its starts; 0 outside the picture.

        name: colour, depth (metres) or classes. step: stride of the pixels.
        """
        picture = self.small["pairs"][batch.pairs, 0].long()
        values = self.maps[name]
        if isinstance(values, torch.Tensor):
            chosen = values[picture]
        else:
            order, back = np.unique(picture.cpu().numpy(), return_inverse=True)
            chosen = torch.as_tensor(_signed(values[order]))[torch.as_tensor(back)].to(self.device)
        chosen = torch.where(batch.mirrored.view(-1, *(1 for _ in chosen.shape[1:])), chosen.flip(2), chosen)
        lens = self.small["lens"][picture]
        own = torch.where(batch.mirrored, 1 - lens[:, 1], lens[:, 1])
        shift = (batch.start.lens[:, 1:] - torch.stack([own, lens[:, 2]], -1)) * self.width
        moved = _moved(chosen, torch.round(shift).long(), step)
        return moved.float() / 1000 if name == "depth" else moved

    def height_maps(self, batch: Batch) -> torch.Tensor:
        """Return height maps (B, 2, CELLS, CELLS) around the starts, metres."""
        picture = self.small["pairs"][batch.pairs, 0].long()
        room = self.small["room_of_picture"][picture].long()
        raw = self.small["heights"][room].float()
        grids = torch.where(raw == NOTHING, torch.full_like(raw, -1), raw * HEIGHT_UNIT)[:, None]
        local = batch.start.root.clone()
        local[batch.mirrored, 0] *= -1
        places = (local[:, None] @ self.axes[picture].transpose(1, 2))[:, 0] + self.eye[picture]
        made = height_map.around(
            grids, self.small["corners"][room], HEIGHT_CELL, places[:, [0, 2]], self.yaw[picture]
        )
        return torch.where(batch.mirrored.view(-1, 1, 1, 1), made.flip(2), made)

    def depth(self, batch: Batch) -> torch.Tensor:
        """Return depth maps (B, 1, *DECODED), metres; 20 m where there is no depth."""
        made = self.pictures("depth", batch, self.width // scene_encoder.DECODED[1])
        return torch.where(made > 0, made, torch.full_like(made, 20.0))[:, None]

    def views(self, view: str, batch: Batch) -> torch.Tensor:
        """Return the encoder's input for a view of networks.VIEWS."""
        if view == "height":
            return self.height_maps(batch)
        if view == "colour":
            return scene_encoder.normalised(self.pictures("colour", batch))
        depth = self.pictures("depth", batch)
        return scene_encoder.geometry(depth, scene_encoder.normals_of(depth, batch.start.lens))

    def targets(self, batch: Batch) -> dict[str, torch.Tensor]:
        """Return the targets of a decoder, of DECODED size.

        depth: (B, 1, H, W) metres, 0 where there is none. normal: (B, 3, H, W). classes: (B, H, W). known: (B, H, W),
        1 where there is depth.
        """
        step = self.width // scene_encoder.DECODED[1]
        depth = self.pictures("depth", batch)
        normal = scene_encoder.normals_of(depth, batch.start.lens)[:, step // 2 :: step, step // 2 :: step]
        depth = depth[:, step // 2 :: step, step // 2 :: step]
        found = {"depth": depth[:, None], "normal": normal.permute(0, 3, 1, 2), "known": (depth > 0).float()}
        if "classes" in self.maps:
            found["classes"] = self.pictures("classes", batch, step).long()
        return found


def load(folder: Path, device: torch.device | str = "cpu", resident: bool = False) -> Dataset:
    """Return a split's data set, see make.py."""
    names = [name for name in (*SMALL, *MAPS) if (folder / f"{name}.npy").exists()]
    return Dataset({n: np.load(folder / f"{n}.npy", mmap_mode="r") for n in names}, device, resident)


def _signed(values: np.ndarray) -> np.ndarray:
    """Return uint16 values as int32, which torch can index."""
    return values.astype(np.int32) if values.dtype == np.uint16 else values


def _yawed_axes(yaw: torch.Tensor) -> torch.Tensor:
    """Return axes (P, 3, 3) as frames.yawed_axes does."""
    cos, sin, zero, one = torch.cos(yaw), torch.sin(yaw), torch.zeros_like(yaw), torch.ones_like(yaw)
    rows = ((cos, zero, sin), (zero, one, zero), (-sin, zero, cos))
    return torch.stack([torch.stack(row, -1) for row in rows], -2)


def _mirrored(
    root: torch.Tensor, rotations: torch.Tensor, rest: torch.Tensor, camera: torch.Tensor, lens: torch.Tensor,
    flags: torch.Tensor,
) -> tuple[torch.Tensor, ...]:  # fmt: skip
    """Return the arguments mirrored left to right where flags (B,) are set."""
    swap = constants.indices(_MIRRORED, root.device)
    sign = constants.numbers((-1.0, 1.0, 1.0), root.device)
    both = sign[:, None] * sign
    pick = lambda one, other: torch.where(flags.view(-1, *(1 for _ in one.shape[1:])), other, one)
    return (
        pick(root, root * sign),
        pick(rotations, rotations[:, :, swap] * both),
        pick(rest, rest[:, swap] * sign),
        pick(camera, camera * both),
        pick(lens, torch.stack([lens[:, 0], 1 - lens[:, 1], lens[:, 2]], -1)),
    )


def _moved(values: torch.Tensor, shift: torch.Tensor, step: int) -> torch.Tensor:
    """Return maps (B, H, W, ...) shifted by whole pixels (B, 2), with a stride of ``step`` pixels."""
    count, height, width = values.shape[:3]
    rows = torch.arange(step // 2, height, step, device=values.device) - shift[:, 1:]
    columns = torch.arange(step // 2, width, step, device=values.device) - shift[:, :1]
    inside = ((rows >= 0) & (rows < height))[:, :, None] & ((columns >= 0) & (columns < width))[:, None]
    number = torch.arange(count, device=values.device)[:, None, None]
    found = values[number, rows.clamp(0, height - 1)[:, :, None], columns.clamp(0, width - 1)[:, None]]
    return found * inside.view(*inside.shape, *(1 for _ in values.shape[3:])).to(found.dtype)
