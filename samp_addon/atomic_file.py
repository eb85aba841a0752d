"""Atomic writing: a file is complete or absent, whenever the process dies."""

from __future__ import annotations

import glob
import os
import platform
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

ABANDONED = 24 * 3600
"""Seconds after which a temporary file of another machine belongs to no running process."""


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a temporary path in the same folder; move it to ``path`` on success, delete it on failure.

    Temporary files that a killed run left behind for the same path are deleted as well; those of processes that may
    still run, here or on another machine, are not. Creates the folder. Raises OSError.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.stem}.{_host()}.{os.getpid()}.part{path.suffix}")
    try:
        yield part
        part.replace(path)
    finally:
        # Blender writes its own temporary file: the given name with a character appended.
        for leftover in path.parent.glob(f".{glob.escape(path.stem)}.*.part{glob.escape(path.suffix)}*"):
            if _abandoned(leftover, path.stem):
                with suppress(OSError):
                    leftover.unlink(missing_ok=True)


def _host() -> str:
    """Return this machine's name, without what a file's name cannot have."""
    return re.sub(r"\W", "-", platform.node()) or "localhost"


def _abandoned(leftover: Path, stem: str) -> bool:
    """Whether no running process but this one writes a temporary file."""
    host, _, rest = leftover.name.removeprefix(f".{stem}.").partition(".")
    pid = rest.partition(".part")[0]
    if host == _host() and pid.isdigit():
        return int(pid) == os.getpid() or not _runs(int(pid))
    try:
        return time.time() - leftover.stat().st_mtime > ABANDONED
    except OSError:
        return False


def _runs(pid: int) -> bool:
    """Whether a process of this machine runs."""
    if os.name == "nt":  # signal 0 is Ctrl+C there, and an open file cannot be deleted anyway
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
