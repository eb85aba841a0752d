"""Speed of MotionNet's rollout: mixing the experts' outputs, as shipped, against mixing weights for each sample.

Both alternate in one process, so that the ratio is valid on a busy machine; medians of several rounds.

python -m samp_blender.benchmarks.rollout
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
import torch

from ..models.motion_net import LATENT, MotionNet
from ..models.state import SIZE
from ..samp_addon.errors import SampError
from ..samp_addon.methods.samp.load_networks import load_motion_net
from ..samp_addon.methods.samp.request import Request
from ..samp_addon.methods.samp.rollout import generator
from ..samp_addon.motion import Goal

TAKES = (1, 32)
ROUNDS = 7


def network() -> MotionNet:
    """Return the shipped network, or one of the same size with random weights if the file is missing."""
    try:
        return load_motion_net().net
    except SampError:
        return MotionNet().eval()


def milliseconds(work: Callable[[], object]) -> float:
    """Return the duration of one call in milliseconds."""
    began = time.perf_counter()
    work()
    return (time.perf_counter() - began) * 1e3


def steps(net: MotionNet, takes: int) -> tuple[float, float]:
    """Return the median milliseconds of one step of the network: mixing outputs, mixing weights."""
    x, features, z = torch.randn(takes, SIZE), torch.rand(takes, 2048), torch.randn(takes, LATENT)
    both: tuple[list[float], list[float]] = ([], [])
    with torch.inference_mode():
        for _ in range(ROUNDS):
            for mix_weights, times in enumerate(both):
                times.append(milliseconds(lambda m=bool(mix_weights): net.step(x, features, z, m)))
    return statistics.median(both[0][1:]), statistics.median(both[1][1:])


def whole_frames(takes: int) -> float:
    """Return the milliseconds per frame of a complete rollout of walks of 6 m, including state and steering."""
    goal = Goal(np.array([0.0, 0.0, 6.0]), np.array([0.0, 0.0, 1.0]), "walk")
    requests = [Request(np.zeros(3), 0.0, "walk", goal, np.zeros((0, 3)), seed=k) for k in range(takes)]
    frames = 0

    def count(share: float) -> None:
        nonlocal frames
        frames += 5  # progress is called every fifth frame

    took = milliseconds(lambda: generator.generate(requests, count))
    return took / max(frames, 1)


def main() -> None:
    """Print a table."""
    net = network()
    steps(net, 1)
    print(
        "| takes | outputs mixed, ms per step | weights mixed, ms per step | ratio | whole rollout, ms per frame |"
    )
    print("|---|---|---|---|---|")
    for takes in TAKES:
        outputs, weights = steps(net, takes)
        try:
            whole = f"{whole_frames(takes):.1f}"
        except SampError:
            whole = "no weights"
        print(f"| {takes} | {outputs:.1f} | {weights:.1f} | {weights / outputs:.0f} | {whole} |")


if __name__ == "__main__":
    main()
