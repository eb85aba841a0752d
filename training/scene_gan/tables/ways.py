"""Print how far captured bodies get in a window, by their speed at its beginning; for methods/scene_gan/liveliness.py.

python -m samp_blender.training.scene_gan.tables.ways --data DATA/train

Windows that begin upright, of all rooms: a row for each range of speeds, with quantiles of the way.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ....samp_addon.methods.scene_gan.liveliness import SHARES, SPEEDS
from ..data.room_windows import BEFORE
from ..data.units import ROOT_UNIT

FPS = 30
UPRIGHT = 0.75  # least height of the pelvis over the floor, metres


def quantiles(root: np.ndarray) -> np.ndarray:
    """Return the ways (len(SPEEDS), len(SHARES)), metres, of windows of the pelvis (W, 66, 3)."""
    flat, upright = root[..., [0, 2]], root[:, BEFORE, 1] > UPRIGHT
    speed = FPS * np.linalg.norm(flat[:, BEFORE] - flat[:, BEFORE - 1], axis=-1)
    way = np.linalg.norm(flat[:, -1] - flat[:, BEFORE], axis=-1)
    kind = np.searchsorted(SPEEDS, speed, side="right")
    return np.stack([np.quantile(way[upright & (kind == k)], SHARES) for k in range(len(SPEEDS) + 1)])


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True)
    found = quantiles(ROOT_UNIT * np.load(parser.parse_args().data / "root.npy").astype(np.float64))
    for row in found:
        print("    (" + ", ".join(f"{value:.2f}" for value in row) + "),")


if __name__ == "__main__":
    main()
