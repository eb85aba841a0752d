"""Sheets of captured and generated windows, each in its picture, from above and from the side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from PIL import Image, ImageDraw

from ....models.scene_gan import kinematics, projection
from ....models.scene_gan.projection import Motions
from ..data.dataset import Batch, Dataset

SCALE = 3  # pixels of a sheet per pixel of the picture
SHOWN = (0, 16, 32, 48, 64)  # frames
ABOVE = 2.5  # metres around the start in the view from above


def colours(share: float) -> tuple[int, int, int]:
    """Return the colour of a time, 0 to 1: blue at the start, red at the end."""
    return int(255 * share), 90, int(255 * (1 - share))


def sheet(data: Dataset, batch: Batch, rows: dict[str, Motions], path: Path) -> None:
    """Write a sheet with a column for each window of a batch, and picture and world views for each of ``rows``."""
    pictures = (
        data.pictures("colour", batch) if "colour" in data.maps else _grey(data.pictures("depth", batch))
    )
    background = pictures.cpu().numpy().astype(np.uint8)
    height, width = (SCALE * n for n in background.shape[1:3])
    made = Image.new("RGB", (width * len(background), len(rows) * 2 * height), "white")
    for row, (name, motions) in enumerate(rows.items()):
        places = projection.project(motions.joints, batch.start).detach().cpu().numpy() * width
        world = motions.joints.detach().cpu().numpy()
        for column, picture in enumerate(background):
            tile = Image.fromarray(picture).resize((width, height))
            draw = ImageDraw.Draw(tile)
            for frame in SHOWN:
                _skeleton(draw, places[column, frame], colours(frame / 64))
            draw.text((3, 3), name, fill="white")
            made.paste(tile, (column * width, 2 * row * height))
            made.paste(_side(world[column], (width, height)), (column * width, (2 * row + 1) * height))
    made.save(path)


def _grey(depth: torch.Tensor) -> torch.Tensor:
    near = (255 * (1 - depth / 8)).clamp(0, 255)
    return near[..., None].expand(*near.shape, 3)


def _skeleton(draw: ImageDraw.ImageDraw, points: np.ndarray, colour: tuple[int, int, int]) -> None:
    for joint, parent in enumerate(kinematics.PARENTS):
        if parent >= 0:
            draw.line([*points[parent], *points[joint]], fill=colour, width=2)


def _side(joints: np.ndarray, size: tuple[int, int]) -> Image.Image:
    """Return the path from above (left half) and the bodies from the side along Z (right half)."""
    tile = Image.new("RGB", size, (245, 245, 245))
    draw = ImageDraw.Draw(tile)
    scale = size[1] / 2 / ABOVE
    start = joints[0, 0]
    above = lambda p: ((start[0] - p[0]) * scale + size[0] / 4, (start[2] - p[2]) * scale + size[1] / 2)
    for frame in range(len(joints) - 1):
        line = [*above(joints[frame, 0]), *above(joints[frame + 1, 0])]
        draw.line(line, fill=colours(frame / 64), width=3)
    floor = joints[0, :, 1].min()
    for frame in SHOWN:
        seen = joints[frame]
        points = np.stack(
            [(seen[:, 2] - start[2]) * scale + 3 * size[0] / 4, size[1] * 0.9 - (seen[:, 1] - floor) * scale],
            -1,
        )
        _skeleton(draw, points, colours(frame / 64))
    return tile


def of_samples(data: Dataset, batch: Batch, generated: Motions, path: Path) -> None:
    """Write a sheet of captured and generated windows."""
    sheet(data, batch, {"captured": batch.motions, "generated": generated}, path)
