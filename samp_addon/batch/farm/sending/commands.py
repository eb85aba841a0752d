"""Programs that submit a bundle, run without a shell; what they print goes to a file in the bundle."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path

from ....errors import SampError
from ....progress import Progress

LOG = "submit.log"
LONGEST = 600.0  # seconds that a submission may take
SETTLED = 3.0
"""Seconds after which a program that stays on, such as Dask's client, is taken to have started."""
TICK = 0.1


def run(arguments: Sequence[str], folder: Path, progress: Progress) -> str:
    """Run a program to its end; return the last line that it prints. Raise SampError where it fails.

    progress: asked every moment; the program is stopped if it raises.
    """
    process, log = _started(arguments, folder, False)
    until = time.monotonic() + LONGEST
    try:
        while process.poll() is None:
            progress("Submitting", 0.9)
            if time.monotonic() > until:
                raise SampError(f"'{arguments[0]}' has not ended after {LONGEST:.0f} seconds; see '{log}'.")
            time.sleep(TICK)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    return _last(process, arguments, log)


def start(arguments: Sequence[str], folder: Path, progress: Progress) -> Path:
    """Start a program that goes on when Blender ends; return its log. Raise SampError where it fails at once."""
    process, log = _started(arguments, folder, True)
    until = time.monotonic() + SETTLED
    while process.poll() is None and time.monotonic() < until:
        progress("Submitting", 0.9)
        time.sleep(TICK)
    if process.poll() is not None:
        _last(process, arguments, log)
    return log


def _started(arguments: Sequence[str], folder: Path, stays: bool) -> tuple[subprocess.Popen, Path]:
    log = folder / LOG
    options = {"start_new_session": True} if stays and os.name != "nt" else {}
    try:
        with log.open("wb") as file:
            return subprocess.Popen(  # noqa: S603 (the artist's own command line, without a shell)
                list(arguments),
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                **options,
            ), log
    except FileNotFoundError as error:
        raise SampError(
            f"There is no program '{arguments[0]}'; install it, or name another one in the add-on's preferences."
        ) from error
    except OSError as error:
        raise SampError(f"'{arguments[0]}' cannot be started ({error.strerror}).") from error


def _last(process: subprocess.Popen, arguments: Sequence[str], log: Path) -> str:
    """Return the last line that an ended program printed. Raise SampError for a status other than 0."""
    text = log.read_text(encoding="utf-8", errors="replace").strip()
    last = text.splitlines()[-1].strip()[:300] if text else ""
    if process.returncode != 0:
        raise SampError(
            f"'{arguments[0]}' failed with status {process.returncode}{': ' + last if last else ''}; see '{log}'."
        )
    return last
