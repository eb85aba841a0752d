"""Merge two training sets: some kinds of sequences from one, all others from the other.

python -m samp_blender.training.samp.motion_net.merge BASE.npz OTHER.npz OUT.npz --kinds sit lie
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from .learning.frames import with_defaults

OF_FRAMES = ("root", "rotations", "actions", "contacts", "goal", "goal_action", "bad")
OF_SEQUENCES = (
    "lengths",
    "kinds",
    "pieces",
    "placements",
    "weights",
    "more_pieces",
    "more_placements",
    "open_ends",
    "postures",
)
OF_PIECES = ("piece_centres", "piece_occupancy")


def chosen(raw: dict[str, np.ndarray], keep: np.ndarray) -> dict[str, np.ndarray]:
    """Return the arrays of the sequences with keep (S,) set."""
    frames = np.repeat(keep, raw["lengths"])
    part = {name: raw[name][frames] for name in OF_FRAMES} | {name: raw[name][keep] for name in OF_SEQUENCES}
    return raw | part


def joined(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Concatenate two sets. Raises ValueError if only one of them is to be mirrored, or if their grids differ."""
    if bool(a["mirrored"]) != bool(b["mirrored"]):
        raise ValueError("one of the two sets is mirrored when it is read and the other is not")
    furnished = [one for one in (a, b) if (one["pieces"] >= 0).any()]
    if len({bool(one["goal_grid"]) for one in furnished}) > 1:
        raise ValueError(
            "the grids of one set are drawn around goals and those of the other over whole objects"
        )
    count, most = len(a["piece_centres"]), max(a["more_pieces"].shape[1], b["more_pieces"].shape[1])
    out = {}
    for name in OF_FRAMES + OF_SEQUENCES + OF_PIECES:
        first, second = a[name], b[name]
        if name.startswith("more_"):
            fill = -1 if name == "more_pieces" else 0
            first, second = (_padded(values, most, fill) for values in (first, second))
        if name in ("pieces", "more_pieces"):
            second = np.where(second < 0, -1, second + count)
        out[name] = np.concatenate([first, second])
    return out | {"mirrored": a["mirrored"], "goal_grid": (furnished or [a])[0]["goal_grid"]}


def _padded(values: np.ndarray, most: int, fill: int) -> np.ndarray:
    missing = [(0, 0), (0, most - values.shape[1]), (0, 0)][: values.ndim]
    return np.pad(values, missing, constant_values=fill)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("base", type=Path)
    parser.add_argument("other", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--kinds", nargs="+", required=True, help="kinds taken from OTHER")
    options = parser.parse_args()
    base, other = (with_defaults(dict(np.load(path))) for path in (options.base, options.other))
    taken = np.isin(other["kinds"], options.kinds)
    whole = joined(chosen(base, ~np.isin(base["kinds"], options.kinds)), chosen(other, taken))
    np.savez_compressed(options.output, **whole)
    for kind in np.unique(whole["kinds"]):
        frames = whole["lengths"][whole["kinds"] == kind]
        print(f"{kind}: {len(frames)} sequences, {frames.sum() / 1800:.1f} minutes")


if __name__ == "__main__":
    main()
