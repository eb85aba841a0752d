"""The number of threads that torch uses."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def single_thread(enabled: bool = True) -> Iterator[None]:
    """Limit torch to one thread inside the context; with enabled false, do nothing.

    For small tensors several threads gain little, and while a window draws they wait for each other.
    """
    import torch

    before = torch.get_num_threads()
    if enabled:
        torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
