"""The command that bakes a jobs file on a Dask cluster: python -m samp_blender.batch.dask."""

from __future__ import annotations

import argparse
import os
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...errors import SampError, UsageError
from .. import command_line, jobs_file, report_file
from ..console import Console
from ..results import views
from .chunks import Chunk, Work, bake_chunk, chunks
from .merge import merge
from .progress_bar import ProgressBar

DONE, FAILED, UNUSABLE = 0, 1, 2
_UNUSED = ("part", "lines", "merge", "progress")


def main(arguments: Sequence[str], bake: Any = bake_chunk) -> int:
    """Run the command; return its exit status, that of the batch. Errors are one line on standard error.

    bake: what a worker does with a chunk.
    """
    console = Console()
    try:
        return _run(_parser().parse_args(list(arguments)), console, bake)
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] not in ("dask", "distributed"):
            raise
        console.complain(
            "The Python package 'distributed' is missing; install it here and on all workers: pip install distributed."
        )
        return UNUSABLE
    except UsageError as error:
        console.complain(str(error))
        return UNUSABLE
    except SampError as error:
        console.complain(str(error))
        return FAILED
    except KeyboardInterrupt:
        console.complain("Stopped; the same command continues with what is not done.")
        return FAILED


def _parser() -> argparse.ArgumentParser:
    made = command_line.parser()
    made.prog = "python -m samp_blender.batch.dask"
    made.description = (
        "Bakes the takes of a jobs file on a Dask cluster; options of bake.py are for all its lines."
    )
    add = made.add_argument
    add("file", metavar="JOBS", type=command_line.file_name, help="jobs file")
    add(
        "--scheduler", required=True, metavar="ADDRESS", help="of a scheduler, its scheduler file, or local:N"
    )
    add("--chunk", type=int, metavar="K", default=25, help="lines for each task (25)")
    add("--retries", type=int, metavar="R", default=3, help="how often a chunk is submitted again (3)")
    add("--dashboard", metavar="HOST:PORT", default=":8787", help="of the page of local:N (:8787)")
    return made


def _run(given: argparse.Namespace, console: Console, bake: Any) -> int:
    options = dict(vars(given))
    own = {name: options.pop(name) for name in ("file", "scheduler", "chunk", "retries", "dashboard")}
    for name in _UNUSED:
        if name in options:
            raise UsageError(f"--{name} is for bake.py; here the workers share all lines.")
    if own["chunk"] < 1 or own["retries"] < 0:
        raise UsageError(
            f"--chunk is {own['chunk']} and --retries {own['retries']}; choose at least 1 and 0."
        )
    jobs = Path(os.path.abspath(options.pop("jobs", own["file"])))
    report = Path(os.path.abspath(options.pop("report"))) if "report" in options else None
    asked = {name: os.path.abspath(options.pop(name)) for name in command_line.VIEWS if name in options}
    views.check(asked)
    pieces = chunks((number for number, _ in jobs_file.lines(jobs)), own["chunk"])
    folder = Path(options.pop("relative_to", "."))
    reports = (report or jobs).with_name(f"{(report or jobs).name}.parts")
    work = Work(
        options | {"jobs": str(jobs)},
        os.path.abspath(folder.parent if folder.is_file() else folder),
        str(reports),
    )
    failed, lost = _bake(own, work, pieces, console, bake)
    joined = merge([reports] if reports.is_dir() else [], jobs)
    _explain(joined["errors"], lost)
    report_file.write(report, joined)
    views.write(asked, joined)
    shutil.rmtree(reports, ignore_errors=True)
    for error in joined["errors"]:
        console.complain(f"Line {error['line']}: {error['message']}")
    return FAILED if failed and options.get("on_failure") != "report" else DONE


def _bake(
    own: dict[str, Any], work: Work, pieces: Sequence[Chunk], console: Console, bake: Any
) -> tuple[int, list[Any]]:
    """Bake all chunks; return how many lines failed, and the chunks that were given up."""
    from . import dask_cluster

    bar = ProgressBar(sum(piece.count for piece in pieces))
    with dask_cluster.connected(own["scheduler"], own["dashboard"]) as client:
        console.say(f"{len(pieces)} tasks; dashboard: {client.dashboard_link}")
        return dask_cluster.bake_all(client, work, pieces, own["retries"], bar.show, bake)


def _explain(errors: Sequence[dict], lost: Sequence[Any]) -> None:
    """Say of lines without a report why their chunk was given up."""
    for error in errors:
        for each in lost:
            if "job" not in error and each.chunk.first <= error["line"] <= each.chunk.last:
                error["message"] = each.reason
