"""Training steps recorded as CUDA graphs."""

from __future__ import annotations

from collections.abc import Callable

import torch


def recorded(
    step: Callable[[], None], optimisers: tuple[torch.optim.Optimizer, ...], warm_up: int
) -> torch.cuda.CUDAGraph:
    """Return a graph whose replay is one training step. The step is run ``warm_up`` times first, as CUDA requires.

    A step consists of hundreds or thousands of small kernels, each of which takes longer to launch than to run. It must
    not read values on the host or copy any from there. optimisers: those whose gradients the step sets.
    """
    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(stream):
        for _ in range(warm_up):
            step()
        for optimiser in optimisers:
            optimiser.zero_grad(set_to_none=True)
    torch.cuda.current_stream().wait_stream(stream)
    torch.cuda.synchronize()
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph):
        step()
    return graph
