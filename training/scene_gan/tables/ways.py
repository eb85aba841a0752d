"""Print how far captured bodies get in a window, by their speed at its beginning; for methods/scene_gan/liveliness.py.

python -m samp_blender.training.scene_gan.tables.ways --data DATA/train

Windows that begin upright, of all rooms: a row for each range of speeds, and one for all, with quantiles of the way.
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
    """Return the ways (len(SPEEDS) + 1, len(SHARES)), metres, of windows of the pelvis (W, 66, 3)."""
    way, kind = _upright(root)
    return np.stack([np.quantile(way[kind == k], SHARES) for k in range(len(SPEEDS) + 1)])


def quantiles_of_all(root: np.ndarray) -> np.ndarray:
    """Return the ways (len(SHARES),), metres, of windows at any speed."""
    return np.quantile(_upright(root)[0], SHARES)


def _upright(root: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ways, metres, and the ranges of speeds of windows that begin upright."""
    root = root[root[:, BEFORE, 1] > UPRIGHT]
    flat = root[..., [0, 2]]
    speed = FPS * np.linalg.norm(flat[:, BEFORE] - flat[:, BEFORE - 1], axis=-1)
    way = np.linalg.norm(flat[:, -1] - flat[:, BEFORE], axis=-1)
    return way, np.searchsorted(SPEEDS, speed, side="right")


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True)
    root = ROOT_UNIT * np.load(parser.parse_args().data / "root.npy").astype(np.float64)
    for row in (*quantiles(root), quantiles_of_all(root)):
        print("    (" + ", ".join(f"{value:.2f}" for value in row) + "),")


if __name__ == "__main__":
    main()
