"""What workers of Dask do with a chunk in tests; imported by the workers' processes."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from samp_blender.samp_addon.batch.farm.chunks import Chunk, bake_chunk


def with_fakes(work, chunk):
    """Bake with the networks stood in for."""
    import fakes

    return bake_chunk(work, chunk, fakes.TOOLS)


def with_fakes_and_a_death(work, chunk):
    """The same; the worker that gets the first chunk dies once, when one line is done."""
    marker = Path(work.folder) / "died"
    if chunk.first == 1 and not marker.exists():
        with_fakes(work, Chunk(1, 1, 1))
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return with_fakes(work, chunk)


def callbacks():
    """Return what the worker does at times."""
    import distributed

    return sorted(distributed.get_worker().periodic_callbacks)


def slow(work, chunk):
    """Note the start and the end of a chunk, with half a second between; without Blender."""
    note(work, f"begun {chunk.name} {os.getpid()}")
    time.sleep(0.5)
    note(work, f"done {chunk.name} {os.getpid()}")
    return 0


def failing(work, chunk):
    """Raise an error; one that passes, where the options say so."""
    note(work, f"begun {chunk.name}")
    begun = (Path(work.folder) / "log").read_text().count(f"begun {chunk.name}\n")
    if begun <= work.options.get("errors", 1000):
        raise RuntimeError("no luck")
    return 1


def note(work, text):
    with (Path(work.folder) / "log").open("a") as file:
        file.write(text + "\n")
