"""The batch: jobs from a command line or a file, without a window. docs/batch.md says how it is used."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..blender.scene import open_scene
from ..blender.takes import reporting
from ..errors import SampError, UsageError
from ..pipeline.driver import Toolbox
from . import command_line, many, report_file
from .build import build
from .carry_out import carry_out, require_scene
from .command_line import VIEWS
from .console import Console, counted
from .farm import stopping
from .farm.merge import merge
from .order import PATHS, order
from .results import views

DONE, FAILED, UNUSABLE = 0, 1, 2


def main(arguments: Sequence[str], tools: Toolbox | None = None) -> int:
    """Run the batch; return its exit status. Errors are one line on standard error."""
    console = Console()
    try:
        with stopping.stoppable():
            options = command_line.parse(arguments)
            console = Console(options.get("progress"))
            options = _from_folder(options)
            views.check(options)
            if "merge" in options:
                return _merge(options, console)
            if "jobs" in options:
                return _many(options, tools, console)
            return _one(options, tools, console)
    except UsageError as error:
        return _failed(console, str(error), UNUSABLE)
    except SampError as error:
        return _failed(console, str(error), FAILED)
    except KeyboardInterrupt:
        return _failed(console, "Stopped.", FAILED)


def _failed(console: Console, reason: str, status: int) -> int:
    console.complain(reason)
    console.fail(reason)
    return status


def _one(options: Mapping[str, Any], tools: Toolbox | None, console: Console) -> int:
    for name in ("part", "lines", "on_failure", "relative_to"):
        if name in options:
            raise UsageError(f"--{name.replace('_', '-')} is for jobs files; name one with --jobs.")
    own = {name: value for name, value in options.items() if name not in command_line.FARM}
    made = order(own, open_scene.open_file())
    require_scene(made)
    outcome = carry_out(made, tools, console)
    for error in outcome.errors:
        console.complain(error["message"])
    content = reporting.report(outcome.variants, outcome.errors)
    content |= {"builds": [build()], "job": made.options()}
    report_file.write(made.report, content)
    views.write(options, content)
    if outcome.errors:
        console.fail(outcome.errors[0]["message"])
        return FAILED
    files = ", ".join(map(str, outcome.files)) or "the report"
    console.say(f"Baked {counted(len(outcome.variants), 'take')}: {files}")
    return DONE


def _many(options: Mapping[str, Any], tools: Toolbox | None, console: Console) -> int:
    if {"part", "lines"} & set(options):
        views.refuse(options, "of a part is of no use; write it with --merge")
    tally = many.bake_lines(options, tools, console)
    views.write(options, tally.report)
    if not tally.failed or options.get("on_failure") == "report":
        return DONE
    console.fail(tally.reason)
    return FAILED


def _merge(options: Mapping[str, Any], console: Console) -> int:
    """Join reports into one; the status is that of a run over all lines."""
    if "report" not in options:
        raise UsageError("Say where the joined report goes with --report.")
    other = sorted(
        set(options) - {"merge", "report", "jobs", "on_failure", "progress", "relative_to", *VIEWS}
    )
    if other:
        raise UsageError(
            f"--merge joins reports and bakes nothing; leave out --{other[0].replace('_', '-')}."
        )
    jobs = Path(options["jobs"]) if "jobs" in options else None
    joined = merge([Path(name) for name in options["merge"]], jobs)
    report_file.write(Path(options["report"]), joined)
    views.write(options, joined)
    if len(joined["builds"]) > 1:
        console.complain(
            f"The parts come from {len(joined['builds'])} different builds, so equal lines may give other takes; "
            "the report lists the builds."
        )
    done, failed = counted(len(joined["variants"]), "take"), counted(len(joined["errors"]), "error")
    console.say(f"Merged {done}, {failed}: {options['report']}")
    return FAILED if joined["errors"] and options.get("on_failure") != "report" else DONE


def _from_folder(options: dict[str, Any]) -> dict[str, Any]:
    """Enter the folder of --relative-to, in which the names of a jobs file begin; names of the command line stay."""
    if "relative_to" not in options:
        return options
    made = dict(options)
    for name in set(made) & {*PATHS, *VIEWS, "jobs", "cast"}:
        made[name] = os.path.abspath(made[name])
    if "merge" in made:
        made["merge"] = [os.path.abspath(name) for name in made["merge"]]
    folder = Path(made["relative_to"])
    try:
        os.chdir(folder.parent if folder.is_file() else folder)
    except OSError as error:
        raise UsageError(f"--relative-to '{folder}' cannot be entered ({error.strerror}).") from error
    return made
