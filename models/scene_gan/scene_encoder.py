"""The scene encoder: a picture to 256 numbers by ResNet-18, with a decoder for its supervision (section 3.1)."""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional

from . import constants

MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
"""Mean and standard deviation of colours for published ResNet-18 weights."""
DECODED = (36, 64)
MIDDLE_DEPTH = 3.0  # depth (m) decoded from a zero output
CLASSES = 13
GRID = (4, 8)


class _Block(nn.Module):
    """Two convolutions around a shortcut (He et al. 2016); names as in published weights."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(outputs)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(outputs)
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs)
            )
        else:
            self.downsample = nn.Identity()

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        y = torch.relu(self.bn1(self.conv1(x)))
        return torch.relu(self.bn2(self.conv2(y)) + self.downsample(x))


class ResNet18(nn.Module):
    """ResNet-18 without its classifier. channels: of the input. width: of the first stage, 64 in the paper."""

    def __init__(self, channels: int = 3, width: int = 64) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(channels, width, 7, 2, 3, bias=False)
        self.bn1 = nn.BatchNorm2d(width)
        inputs = width
        for number, outputs in enumerate((width, 2 * width, 4 * width, 8 * width), start=1):
            blocks = _Block(inputs, outputs, 1 if number == 1 else 2), _Block(outputs, outputs, 1)
            setattr(self, f"layer{number}", nn.Sequential(*blocks))
            inputs = outputs

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return the last feature map (B, 8 width, H / 32, W / 32)."""
        x = functional.max_pool2d(torch.relu(self.bn1(self.conv1(x))), 3, 2, 1)
        for number in (1, 2, 3, 4):
            x = getattr(self, f"layer{number}")(x)
        return x


class SceneEncoder(nn.Module):
    """An encoder of a picture to a scene feature, with a decoder of the feature to depth, normals and classes.

    The decoder has no other input, so that the feature has to contain the structure of the scene. channels: 3 for
    colours, 4 for inverse depth and normals.
    """

    def __init__(self, scene: int = 256, channels: int = 3, width: int = 64) -> None:
        super().__init__()
        self.trunk = ResNet18(channels, width)
        # Pooling to a single cell would discard positions.
        self.narrow = nn.Conv2d(8 * width, width, 1)
        self.feature = nn.Linear(width * GRID[0] * GRID[1], scene)
        self.decoder = SceneDecoder(scene, width)

    def forward(self, pictures: torch.Tensor) -> torch.Tensor:
        """Return features (B, scene) of pictures (B, channels, H, W), see `normalised`."""
        seen = functional.adaptive_avg_pool2d(self.narrow(self.trunk(pictures)), GRID)
        return self.feature(torch.relu(seen).flatten(1))

    def load_published(self, tensors: dict[str, torch.Tensor]) -> None:
        """Load ResNet-18 weights with the usual names, such as ImageNet's; the classifier ``fc`` is left out.

        Raise RuntimeError where they do not fit.
        """
        kept = {name: value for name, value in tensors.items() if not name.startswith("fc.")}
        self.trunk.load_state_dict(kept)


class SceneDecoder(nn.Module):
    """A decoder of a scene feature to maps of DECODED size: depth (metres), normals, classes."""

    def __init__(self, scene: int, width: int) -> None:
        super().__init__()
        self.width = 2 * width
        self.spread = nn.Linear(scene, self.width * GRID[0] * GRID[1])
        self.blocks = nn.ModuleList(
            nn.Conv2d(a, b, 3, padding=1)
            for a, b in ((self.width, self.width), (self.width, width), (width, width))
        )
        self.last = nn.Conv2d(width, 1 + 3 + CLASSES, 3, padding=1)

    def forward(self, feature: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return depth (B, 1, H, W), unit normals (B, 3, H, W) in camera coordinates, class logits (B, 13, H, W)."""
        x = self.spread(feature).view(-1, self.width, *GRID)
        for block, size in zip(self.blocks, ((9, 16), (18, 32), DECODED), strict=True):
            x = functional.interpolate(x, size=size, mode="bilinear", align_corners=False)
            x = functional.leaky_relu(block(x), 0.2)
        made = self.last(x)
        depth = MIDDLE_DEPTH * torch.exp(made[:, :1].clamp(-4, 3))
        return depth, functional.normalize(made[:, 1:4], dim=1), made[:, 4:]


def normalised(colours: torch.Tensor) -> torch.Tensor:
    """Return network inputs (B, 3, H, W) of colours (B, H, W, 3), uint8."""
    mean = constants.numbers(MEAN, colours.device)
    deviation = constants.numbers(DEVIATION, colours.device)
    return ((colours.float() / 255 - mean) / deviation).permute(0, 3, 1, 2).contiguous()


def normals_of(depth: torch.Tensor, lens: torch.Tensor) -> torch.Tensor:
    """Return normals (B, H, W, 3) in camera coordinates (x right, y down, z forward), towards the camera.

    They are computed from each pixel and its right and lower neighbours, and so independent of the renderer. depth:
    (B, H, W) metres along the camera's axis, 0 where there is none, with normal 0. lens: (B, 3) focal length and
    principal point in widths.
    """
    count, height, width = depth.shape
    y, x = torch.meshgrid(
        (torch.arange(height, device=depth.device) + 0.5) / width,
        (torch.arange(width, device=depth.device) + 0.5) / width,
        indexing="ij",
    )
    focal, middle_x, middle_y = (lens[:, k].view(count, 1, 1) for k in range(3))
    points = torch.stack([(x - middle_x) / focal * depth, (y - middle_y) / focal * depth, depth], -1)
    right = functional.pad(points[:, :, 1:] - points[:, :, :-1], (0, 0, 0, 1))
    right[:, :, -1] = right[:, :, -2]
    down = functional.pad(points[:, 1:] - points[:, :-1], (0, 0, 0, 0, 0, 1))
    down[:, -1] = down[:, -2]
    normal = functional.normalize(torch.cross(down, right, dim=-1), dim=-1)
    return normal * (depth > 0)[..., None]


def geometry(depth: torch.Tensor, normals: torch.Tensor) -> torch.Tensor:
    """Return network inputs (B, 4, H, W) of depth (B, H, W), metres, and normals (B, H, W, 3), see `normals_of`.

    Depth is inverted, which emphasises near surfaces; 0 means no depth.
    """
    inverse = torch.where(depth > 0, 1 / depth.clamp(min=0.2), torch.zeros_like(depth))
    return torch.cat([2 * inverse[:, None] - 1, normals.permute(0, 3, 1, 2)], dim=1).contiguous()
