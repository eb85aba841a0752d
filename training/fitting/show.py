"""Render contact sheets of random sequences of a fitted training set, each on its piece, from two sides.

python -m samp_blender.training.fitting.show --data fitted.npz --furniture FOLDER --output FOLDER [--count 8]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ...samp_addon import rotation
from ...samp_addon.motion import Motion
from ..look import look
from .measure import sequences
from .shapes import pieces as furnishing
from .shapes.kept import kept

BEFORE, AFTER = 30, 20  # frames shown before and after the action
SIZE = (240, 240)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--furniture", type=Path)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--kind", default="sit")
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--pieces-seed", type=int, default=0, help="seed with which the set was built")
    parser.add_argument("--kept", type=Path, help="as in fitting.make")
    options = parser.parse_args()
    pieces = kept(options.kept, "pieces", lambda: furnishing.collect(options.furniture, options.pieces_seed))
    taken = [s for s in sequences(options.data) if s.kind == options.kind]
    options.output.mkdir(parents=True, exist_ok=True)
    for k in np.random.default_rng(options.seed).permutation(len(taken))[: options.count]:
        sequence = taken[k]
        rests = np.flatnonzero(sequence.pelvis > 0.5)
        part = slice(max(rests[0] - BEFORE, 0), rests[-1] + AFTER)
        x, z, yaw = sequence.placement
        triangles = pieces[sequence.piece].triangles
        turn = rotation.quaternion_to_matrix(rotation.about_y(yaw))
        sheet = look(
            Motion(sequence.root[part], sequence.rotations[part]),
            (options.output / f"{options.kind}_{k}.png").resolve(),
            triangles=triangles @ turn.T + [x, 0.0, z],
            follow=options.kind == "sit",
            count=6,
            size=SIZE,
        )
        print(sheet, pieces[sequence.piece].name)


if __name__ == "__main__":
    main()
