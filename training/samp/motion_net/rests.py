"""Find how high the pelvis rests in each captured style that MotionNet's weights contain.

python -m samp_blender.training.samp.motion_net.rests --data cache/motion.npz --folder models/weights

A style's code is measured on mean poses over the floor, so it says how high a body rests; a take on a seat of another
height must not be given it. The heights lie in a file of their own, beside weights that were exported before.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch

from ....models import state, weights
from ....samp_addon.methods.samp.load_networks import RESTS
from ....samp_addon.vocabulary import ACTIONS, SEATED
from .learning import frames
from .learning.trainer import window

FEWEST = 20  # frames of a rest
LOW = 0.3  # quantile of the heights during a rest: the first and last frames sink and rise
EXACT = 0.02  # largest difference between a style and its code in half precision


def rest_heights(data: frames.Frames) -> torch.Tensor:
    """Return the metres (S,) of the resting pelvis over the floor in each sequence, 0 where nobody rests for long."""
    busy = data.states[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW, 4:].float()
    rests = busy[:, [ACTIONS.index(action) for action in SEATED]].sum(1) > 0.5
    heights = data.states[:, state.POSE][:, 1].float()
    out = torch.zeros(len(data.styles))
    resting, owner = heights[rests], data.sequence[rests]
    numbers, counts = torch.unique_consecutive(owner, return_counts=True)
    for number, part in zip(numbers.tolist(), torch.split(resting, counts.tolist()), strict=True):
        if len(part) >= FEWEST:
            out[number] = part.quantile(LOW)
    return out


def of_codes(codes: torch.Tensor, styles: torch.Tensor, heights: torch.Tensor) -> torch.Tensor:
    """Return the heights (K,) of the sequences with the codes (K, L); 0 for codes of none.

    styles: (S, L) of the sequences. heights: (S,) metres.
    """
    apart = torch.cdist(codes.float(), styles.float(), p=torch.inf)
    least, own = apart.min(1)
    return torch.where(least < EXACT, heights[own], 0.0)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--folder", type=Path, default=weights.FOLDER, help="of the weights")
    options = parser.parse_args()
    data = frames.load(options.data, "cpu", window())
    tensors = weights.load_weights("motion_net", options.folder)
    codes, held = tensors["style_codes"], int(tensors["held"])
    heights = rest_heights(data)
    out = torch.zeros(codes.shape[:2])
    for action in map(ACTIONS.index, SEATED):
        out[action] = of_codes(codes[action, :, :held], data.styles[:, :held], heights)
        known = out[action][out[action] > 0]
        print(f"{ACTIONS[action]}: {len(known)} of {codes.shape[1]} styles with a height")
    print(weights.save_weights(RESTS, {"style_heights": out}, options.folder))


if __name__ == "__main__":
    main()
