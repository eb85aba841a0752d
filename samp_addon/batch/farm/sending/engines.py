"""Where a bundle goes: nowhere, to AWS Deadline Cloud, Flamenco, Dask, or by a command line of the studio's own."""

from __future__ import annotations

import os
import shlex
from dataclasses import dataclass

from ....errors import SampError
from ....progress import Progress
from . import commands, flamenco
from .bundle import Bundle, Workers, flamenco_job

NONE, OPENJD, FLAMENCO, DASK, COMMAND = ENGINES = ("NONE", "OPENJD", "FLAMENCO", "DASK", "COMMAND")
DEADLINE = "deadline bundle submit --yes {bundle}"
MANAGER = "http://localhost:8080"
PLACEHOLDERS = ("jobs", "output", "lines", "bundle", "scene", "name", "chunk")


@dataclass(frozen=True)
class Engine:
    """How bundles are submitted.

    kind: one of ENGINES. command: command line of OPENJD and COMMAND, with placeholders in braces. manager: address of
    Flamenco's manager. scheduler: what --scheduler of the Dask command takes. python: of an environment that has
    samp_blender and distributed, for Dask.
    """

    kind: str = NONE
    command: str = ""
    manager: str = MANAGER
    scheduler: str = ""
    python: str = ""
    workers: Workers = Workers()


def check(engine: Engine, online: bool) -> None:
    """Raise SampError where nothing can be submitted, before anything is written. online: whether Blender may use the
    network; it is asked only where this program itself does."""
    if engine.kind not in ENGINES:
        raise SampError(f"There is no engine '{engine.kind}'; choose one of {', '.join(ENGINES)}.")
    if engine.kind == COMMAND and not engine.command.strip():
        raise SampError("There is no command line for the farm; write one in the add-on's preferences.")
    if engine.kind == DASK and not (engine.scheduler and engine.python):
        raise SampError(
            "Dask needs a scheduler's address and a Python; set both in the add-on's preferences."
        )
    if engine.kind == FLAMENCO:
        flamenco.check(engine.manager)
        if not online:
            raise SampError(
                "Blender's online access is off, so Flamenco cannot be reached; allow it in the preferences (System)."
            )
    if engine.kind in (OPENJD, COMMAND):
        words(engine.command or DEADLINE)


def submit(engine: Engine, bundle: Bundle, progress: Progress = lambda stage, share: None) -> str:
    """Submit a bundle; return the sentence to report. Raise SampError where it is not taken, and what progress
    raises. The bundle stays as it is."""
    if engine.kind == NONE:
        return (
            f"Wrote '{bundle.folder}' with {bundle.count} jobs; no engine is set in the add-on's preferences."
        )
    progress("Submitting", 0.9)
    if engine.kind == FLAMENCO:
        job = flamenco.post(engine.manager, flamenco_job(bundle, engine.workers))
        return f"Sent {bundle.count} jobs to Flamenco as job {job}."
    if engine.kind == DASK:
        log = commands.start(_dask(engine, bundle), bundle.folder, progress)
        return f"Dask bakes {bundle.count} jobs; see '{log}'."
    line = filled(engine.command or DEADLINE, bundle, engine.workers)
    last = commands.run(line, bundle.folder, progress)
    return f"Sent {bundle.count} jobs: {last}" if last else f"Sent {bundle.count} jobs by '{line[0]}'."


def words(command: str) -> list[str]:
    """Return the words of a command line. Raise SampError where quotes are left open."""
    try:
        found = shlex.split(command, posix=os.name != "nt")
    except ValueError as error:
        raise SampError(f"The command line for the farm cannot be read ({error}).") from error
    return [word.strip('"') for word in found] if os.name == "nt" else found


def filled(command: str, bundle: Bundle, workers: Workers) -> list[str]:
    """Return the words of a command line, its placeholders replaced; other braces stay as they are."""
    values = {
        "jobs": bundle.jobs,
        "output": bundle.output,
        "lines": bundle.count,
        "bundle": bundle.folder,
        "scene": bundle.scene,
        "name": bundle.name,
        "chunk": workers.chunk,
    }
    made = words(command)
    for name in PLACEHOLDERS:
        made = [word.replace(f"{{{name}}}", str(values[name])) for word in made]
    return made


def _dask(engine: Engine, bundle: Bundle) -> list[str]:
    return [
        engine.python, "-m", "samp_blender.batch.dask", "--scheduler", engine.scheduler, str(bundle.jobs),
        "--relative-to", str(bundle.folder), "--chunk", str(engine.workers.chunk), "--on-failure", "report",
        "--report", str(bundle.output / "report.json"), "--page", str(bundle.output / "index.html"),
        "--table", str(bundle.output / "takes.csv"),
    ]  # fmt: skip
