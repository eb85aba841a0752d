"""Constant tensors, made once for each device: a step that copies from the host cannot be captured as a graph."""

from __future__ import annotations

from functools import cache

import torch


@cache
def numbers(values: tuple[float, ...], device: torch.device) -> torch.Tensor:
    """Return a tensor (N,) of values."""
    with torch.inference_mode(False):  # it may be used in training later
        return torch.tensor(values, dtype=torch.float32, device=device)


@cache
def indices(values: tuple[int, ...], device: torch.device) -> torch.Tensor:
    """Return a tensor (N,) of int64, to index another tensor with."""
    with torch.inference_mode(False):
        return torch.tensor(values, dtype=torch.int64, device=device)
