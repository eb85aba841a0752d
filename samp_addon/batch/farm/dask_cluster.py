"""Chunks of a jobs file as tasks of a Dask cluster. Imports `distributed`, which is an optional dependency."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import dask
import distributed

from ...errors import UsageError
from .chunks import Chunk, Work, bake_chunk

WAITING = 2000
"""Tasks that the scheduler holds at a time."""

LOSSES = 3
"""Times that a chunk is submitted again, beyond the retries, because its result was lost with a worker."""

EVERY = 2.0
"""Seconds between two looks at the number of workers."""

CONNECT = 30
"""Seconds in which a scheduler has to answer."""

SETTINGS = {"distributed.worker.profile.enabled": False}
"""Of Dask on this machine's workers: its profiler looks at the stack a hundred times a second and keeps what it sees,
0.2 MB a second of every worker."""

Bake = Callable[[Work, Chunk], int]


@dataclass(frozen=True)
class Lost:
    """A chunk that was given up: its task failed, or the workers that ran it died, too often."""

    chunk: Chunk
    reason: str


@contextmanager
def connected(scheduler: str, dashboard: str) -> Iterator[distributed.Client]:
    """Yield a client of a cluster.

    scheduler: local:N starts N workers on this machine, one process with one thread each; otherwise the address of a
    scheduler or its scheduler file. dashboard: address of the local cluster's page. Raise UsageError where no
    scheduler answers.
    """
    if scheduler.startswith("local:"):
        workers = scheduler.removeprefix("local:")
        if not workers.isdigit() or int(workers) == 0:
            raise UsageError(f"--scheduler is '{scheduler}'; write local:N with N workers, such as local:4.")
        with (
            dask.config.set(SETTINGS),
            distributed.LocalCluster(
                n_workers=int(workers), threads_per_worker=1, processes=True, dashboard_address=dashboard
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client
        return
    where = {"scheduler_file": scheduler} if Path(scheduler).is_file() else {"address": scheduler}
    try:
        client = distributed.Client(**where, timeout=CONNECT)
    except (OSError, ValueError) as error:
        raise UsageError(f"No Dask scheduler answers at '{scheduler}' ({error}).") from error
    with client:
        yield client


def bake_all(
    client: distributed.Client,
    work: Work,
    pieces: Sequence[Chunk],
    retries: int,
    progress: Callable[[int, int, int], None] = lambda done, failed, workers: None,
    bake: Bake = bake_chunk,
) -> tuple[int, list[Lost]]:
    """Bake all chunks; return the number of failed lines and the chunks that were given up.

    A chunk whose worker dies is given to another one; Dask gives it up after some deaths (its `allowed-failures`), and
    then, as after an unexpected error, it is submitted again, `retries` times. progress: called with the lines done,
    the lines failed and the number of workers. Raise UsageError where the options cannot be used.
    """
    waiting, tries = list(reversed(pieces)), dict.fromkeys(pieces, 0)
    running: dict[str, Chunk] = {}
    lost: list[Lost] = []
    done = failed = 0

    def submit(chunk: Chunk) -> distributed.Future:
        # A new key each time: a key that has failed once would give the same error again.
        key = f"samp-{chunk.name}-{uuid.uuid4().hex[:8]}"
        running[key] = chunk
        return client.submit(_on_worker, bake, work, chunk, key=key, pure=False)

    completed = distributed.as_completed([submit(waiting.pop()) for _ in range(min(WAITING, len(waiting)))])
    count = _WorkerCount(client)
    progress(done, failed, count())
    for future in completed:
        chunk = running.pop(future.key)
        error = None if future.status == "finished" else _error(future)
        if isinstance(error, UsageError):
            raise error
        # A result that was announced and died with its worker is not the chunk's fault.
        allowed = retries + (LOSSES if future.status == "lost" else 0)
        if error is not None and tries[chunk] < allowed:
            tries[chunk] += 1
            waiting.append(chunk)
        elif error is not None:
            lost.append(Lost(chunk, _sentence(error)))
            done, failed = done + chunk.count, failed + chunk.count
        else:
            done, failed = done + chunk.count, failed + future.result()
        if waiting:
            completed.add(submit(waiting.pop()))
        progress(done, failed, count())
    return failed, lost


def _on_worker(bake: Bake, work: Work, chunk: Chunk) -> int:
    """Bake a chunk on a worker, which is the only thing that its process does."""
    threads = distributed.get_worker().state.nthreads
    if threads != 1:
        raise UsageError(
            f"A worker has {threads} threads, but Blender runs once in a process; start workers with --nthreads 1."
        )
    return bake(work, chunk)


def _error(future: distributed.Future) -> BaseException:
    if future.status != "error":
        return RuntimeError(f"the task was {future.status}")
    return future.exception()


def _sentence(error: BaseException) -> str:
    if isinstance(error, distributed.KilledWorker):
        return "The workers that baked this chunk died."
    return " ".join(f"The chunk failed ({type(error).__name__}: {error}).".split())


class _WorkerCount:
    """The number of workers, asked for now and then only."""

    def __init__(self, client: distributed.Client) -> None:
        self._client, self._asked, self._count = client, float("-inf"), 0

    def __call__(self) -> int:
        if time.monotonic() - self._asked > EVERY:
            self._count, self._asked = len(self._client.nthreads()), time.monotonic()
        return self._count
