"""Freed memory is given back to the system, so that a worker on a farm does not grow with its lines."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable


def give_back() -> None:
    """Give freed memory back. The C library keeps the holes between what is still in use, 150 MB after some lines."""
    _trim()(0)


@functools.cache
def _trim() -> Callable[[int], object]:
    """Return glibc's malloc_trim; other C libraries have none, and need none."""
    try:
        return ctypes.CDLL("libc.so.6").malloc_trim
    except (OSError, AttributeError):
        return lambda keep: None
