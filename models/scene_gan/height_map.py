"""A bird's-eye height map around the body in place of the picture, where no picture is available and to compare."""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional

CELLS = 48
CELL = 0.1  # metres; the map covers 2.4 m in each direction, the range of most windows
HIGHEST = 1.8  # height (m) over the floor above which surfaces are not obstacles


class HeightMapEncoder(nn.Module):
    """An encoder of a height map to a scene feature."""

    def __init__(self, scene: int = 256, width: int = 64) -> None:
        super().__init__()
        self.blocks = nn.ModuleList(
            nn.Conv2d(a, b, 3, stride=2, padding=1)
            for a, b in ((2, width // 2), (width // 2, width), (width, 2 * width), (2 * width, 2 * width))
        )
        self.feature = nn.Linear(2 * width * (CELLS // 16) ** 2, scene)

    def forward(self, maps: torch.Tensor) -> torch.Tensor:
        """Return features (B, scene) of maps (B, 2, CELLS, CELLS), see `around`."""
        x = maps
        for block in self.blocks:
            x = functional.leaky_relu(block(x), 0.2)
        return self.feature(x.flatten(1))


def around(
    grids: torch.Tensor, corners: torch.Tensor, cell: float, places: torch.Tensor, yaws: torch.Tensor
) -> torch.Tensor:
    """Return height maps (B, 2, CELLS, CELLS) around places, in view frames: height, metres, and 1 where it is known.

    grids: (B, 1, X, Z) heights over the floor of whole rooms, metres, in cells of ``cell`` metres from corners (B, 2);
    below 0 where there is no surface. places: (B, 2) x and z. yaws: (B,) of the view frames' Z axes, radians. Rows of a
    map are along the view's X, columns along its Z.
    """
    step = (torch.arange(CELLS, device=grids.device) - (CELLS - 1) / 2) * CELL
    along_x, along_z = torch.meshgrid(step, step, indexing="ij")
    cos, sin = torch.cos(yaws)[:, None, None], torch.sin(yaws)[:, None, None]
    x = places[:, 0, None, None] + along_x * cos + along_z * sin
    z = places[:, 1, None, None] - along_x * sin + along_z * cos
    size = torch.tensor(grids.shape[-2:], device=grids.device) * cell
    # grid_sample expects the last axis first.
    at = torch.stack(
        [(z - corners[:, 1, None, None]) / size[1], (x - corners[:, 0, None, None]) / size[0]], -1
    )
    found = functional.grid_sample(grids, 2 * at - 1, mode="nearest", align_corners=False)
    inside = ((at > 0) & (at < 1)).all(-1)[:, None]
    known = (inside & (found >= 0)).float()
    return torch.cat([torch.where(known > 0, found, torch.full_like(found, HIGHEST)), known], dim=1)
