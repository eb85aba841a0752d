"""Measure training steps on a GPU: whether they can be captured and fused, and how long they take.

python -m samp_blender.training.samp.motion_net.learning.probe --data motion.bin --seconds 90
"""

from __future__ import annotations

import argparse
import time
import traceback
from pathlib import Path

import torch

from .....models import motion_net
from . import frames
from .side_by_side import DEFAULTS, Run
from .trainer import window

WARM, TIMED = 20, 200


def milliseconds_per_step(run: Run, steps: int) -> float:
    """Return the duration of a step."""
    for _ in range(WARM):
        run.trainer.step(0.0)
    torch.cuda.synchronize()
    began = time.time()
    for _ in range(steps):
        run.trainer.step(0.0)
    torch.cuda.synchronize()
    return (time.time() - began) / steps * 1000


def case(data: frames.Frames, hidden: int, batch: int, graph: bool, fuse: bool, pad: bool) -> Run:
    """Time one training and print duration, memory and loss."""
    motion_net.PAD_ON_GPU = pad
    began = time.time()
    options = DEFAULTS | {"hidden": hidden, "batch": batch, "seed": 0, "encoder": 0}
    run = Run(f"{hidden}x{batch}", options, data, graph, fuse)
    ready = time.time() - began
    first = milliseconds_per_step(run, 10 if not graph else TIMED)
    losses = run.trainer.losses()
    memory = torch.cuda.max_memory_allocated() / 2**30
    print(
        f"hidden {hidden} batch {batch} graph {graph} fuse {fuse} pad {pad}: {first:.2f} ms a step, ready after "
        f"{ready:.1f} s, loss {losses['loss']:.1f}, {memory:.1f} GiB",
        flush=True,
    )
    return run


def together(runs: list[Run], seconds: float) -> None:
    """Time trainings that run side by side."""
    before = [run.trainer.step_number for run in runs]
    began = time.time()
    while time.time() - began < seconds:
        queued = [run.queue_steps(0.0) for run in runs]
        if not any(queued):
            time.sleep(0.0005)
    torch.cuda.synchronize()
    passed = time.time() - began
    for run, first in zip(runs, before, strict=True):
        print(
            f"side by side {run.name}: {(run.trainer.step_number - first) / passed:.0f} steps/s", flush=True
        )
        print("   ", run.report(), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=100.0, help="start no case later than this")
    options = parser.parse_args()
    began = time.time()
    print(torch.__version__, torch.cuda.get_device_name(), flush=True)
    data = frames.load(options.data, "cuda", window())
    print(f"{len(data)} frames after {time.time() - began:.1f} s", flush=True)
    kept: list[Run] = []
    for hidden, batch, graph, fuse, pad in (
        (512, 2048, False, False, True), (512, 2048, True, False, True), (256, 2048, True, False, True),
        (512, 2048, True, True, True), (256, 2048, True, True, True), (512, 2048, True, True, False),
        (512, 4096, True, True, True),
    ):  # fmt: skip
        if time.time() - began > options.seconds:
            break
        try:
            run = case(data, hidden, batch, graph, fuse, pad)
            kept += [run] if graph and batch == 2048 and pad else []
        except Exception:
            # The probe has to find cases that fail; the remaining ones are still measured.
            traceback.print_exc()
    if kept:
        together(kept[-3:], 5.0)
    print(f"end after {time.time() - began:.1f} s", flush=True)


if __name__ == "__main__":
    main()
