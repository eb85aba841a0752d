"""The batch: jobs from a command line or a file, without a window. docs/batch.md says how it is used."""

from __future__ import annotations

import json
import re
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .. import dependencies
from ..atomic_file import atomic_write
from ..blender.actions import keyframes
from ..blender.cast import baking as cast_baking
from ..blender.cast.baking import CastResult
from ..blender.scene import open_scene
from ..blender.takes import baking, reporting
from ..body import amass
from ..errors import SampError, UsageError
from ..methods.take import Take
from ..pipeline import attempts
from ..pipeline.cast.cast import Cast
from ..pipeline.cast.cast_take import CastTake
from ..pipeline.driver import Toolbox
from . import command_line, jobs_file
from .ledger import Ledger
from .order import Order, order
from .quiet import quiet
from .saved_takes import SavedTakes

DONE, FAILED, UNUSABLE = 0, 1, 2

LONGEST_LINE = 600
"""Characters of a line on standard error."""


@dataclass
class Outcome:
    """What became of one order: the report's variants and errors, and the files written."""

    variants: list[dict] = field(default_factory=list)
    errors: list[dict] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)


def main(arguments: Sequence[str], tools: Toolbox | None = None) -> int:
    """Run the batch; return its exit status. Errors are one line on standard error."""
    try:
        options = command_line.parse(arguments)
        if "jobs" in options:
            return _many(options, tools)
        return _one(options, tools)
    except UsageError as error:
        _complain(str(error))
        return UNUSABLE
    except KeyboardInterrupt:
        _complain("Stopped.")
        return FAILED


def _one(options: Mapping[str, Any], tools: Toolbox | None) -> int:
    made = order(options, open_scene.open_file())
    _require_scene(made)
    outcome = _carry_out(made, tools)
    for error in outcome.errors:
        _complain(error["message"])
    if not _write_report(made.report, outcome.variants, outcome.errors) or outcome.errors:
        return FAILED
    files = ", ".join(map(str, outcome.files)) or "the report"
    _say(f"Baked {_counted(len(outcome.variants), 'take')}: {files}")
    return DONE


def _many(options: Mapping[str, Any], tools: Toolbox | None) -> int:
    """Carry out all jobs of a file; what its ledger holds is not done again."""
    path = Path(options["jobs"])
    lines = jobs_file.lines(path)
    shared = {name: value for name, value in options.items() if name not in ("jobs", "report")}
    report = Path(options["report"]) if "report" in options else None
    run = _Run(shared, Ledger.beside(path), tools, open_scene.open_file())
    variants, errors = [], []
    for count, (number, text) in enumerate(lines, start=1):
        entry, outcome, state = run.line(number, text, f"{count}/{len(lines)} ")
        for error in outcome.errors:
            state = "failed"
            _complain(f"Line {number}: {error['message']}")
        variants += [entry | variant for variant in outcome.variants]
        errors += [entry | error for error in outcome.errors]
        _say(f"{count}/{len(lines)} {state}")
        if not _write_report(report, variants, errors):
            return FAILED
    return FAILED if errors else DONE


@dataclass
class _Run:
    """One run over a jobs file. opened: the file that was open at its start. claimed: which line writes which file."""

    shared: Mapping[str, Any]
    ledger: Ledger
    tools: Toolbox | None
    opened: Path | None
    claimed: dict[Path, tuple[int, str]] = field(default_factory=dict)

    def line(self, number: int, text: str | SampError, label: str) -> tuple[dict, Outcome, str]:
        """Return the report's entry of a line, its outcome, and "done" or "done before"."""
        entry: dict[str, Any] = {"line": number}
        try:
            if isinstance(text, SampError):
                raise text
            made = order(jobs_file.options(text, self.shared), self.opened)
            entry["job"] = made.options()
            _require_scene(made)
            self._claim(made, number)
            variants = self.ledger.recall(made)
            if variants is not None:
                return entry, Outcome(variants=variants), "done before"
            saved = self.ledger.saved(made)
            outcome = _carry_out(made, self.tools, saved, label)
            if not outcome.errors:
                self.ledger.record(made, outcome.variants, outcome.files)
                saved.forget()
                _write_report(made.report, outcome.variants, [])
        except SampError as error:
            outcome = Outcome(errors=[{"message": str(error)}])
        return entry, outcome, "done"

    def _claim(self, made: Order, number: int) -> None:
        """Raise SampError if another line writes the same files with other options."""
        key = json.dumps(made.options(), sort_keys=True)
        files = [made.output] if made.output else []
        files += list(npz_paths(made).values()) if made.npz else []
        for path in files:
            line, other = self.claimed.setdefault(path.absolute(), (number, key))
            if other != key:
                raise SampError(f"'{path}' is written by line {line} already; name another file.")


def _carry_out(
    made: Order, tools: Toolbox | None, saved: SavedTakes | None = None, label: str = ""
) -> Outcome:
    """Carry out one order, from its file to its files; errors are in the outcome. label: before each take's line."""
    try:
        with quiet() as say:
            context, done = open_scene.open_for_job(made.scene or made.opened, made.units, made.up), []

            def on_take(take: Take | CastTake) -> None:
                done.append(take)
                say(f"bake: {label}take {len(done)}/{made.job.variants}: {_line(take)}\n")

            shared = {"tools": tools, "store": saved, "on_take": on_take}
            if isinstance(made.job, Cast):
                result = cast_baking.run(context, made.job, **shared)
            else:
                result = baking.run(context, made.job, new_character=True, **shared)
            files = _write_files(made, result)
    except SampError as error:
        return Outcome(errors=[{"message": str(error)}])
    except Exception as error:
        if sentence := dependencies.explain(error):
            return Outcome(errors=[{"message": sentence}])
        # Never a traceback on the screen; whoever mends the program finds it in the report.
        text = f"Something unexpected went wrong ({type(error).__name__}: {error}); please report it."
        return Outcome(errors=[{"message": " ".join(text.split()), "traceback": traceback.format_exc()}])
    errors = [{"seed": failure.seed, "message": failure.message} for failure in result.failures]
    return Outcome(result.variants, errors, files)


def _line(take: Take | CastTake) -> str:
    """Return what standard output says of a finished take."""
    if isinstance(take, CastTake):
        overlap = f"bodies at most {100 * max(take.deepest, 0):.1f} cm in each other"
        return f"seed {take.seed}, {_counted(len(take.takes), 'character')}, {overlap}"
    if take.goal is None:
        return f"seed {take.seed}, {take.motion.seconds:.1f} s"
    return f"seed {take.seed}, {attempts.error(take):.1f} cm from its goal"


def _require_scene(made: Order) -> None:
    """Raise UsageError where there is no scene, before any work is done."""
    if made.scene is not None and not made.scene.is_file():
        raise UsageError(f"There is no file '{made.scene}'; name the scene to open with --scene.")
    if made.scene is None and not open_scene.is_open():
        raise UsageError("Name the scene to open with --scene FILE.")


def npz_paths(made: Order) -> dict[tuple[int, int], Path]:
    """Return where each take goes, by its seed and its number in a cast: named after scene, action, target and seed."""
    scene = (made.scene or made.opened or Path("untitled")).stem
    if isinstance(made.job, Cast):
        rows = [([member.name], member.job) for member in made.job.members]
    else:
        rows = [([], made.job)]
    found = {}
    for number, (words, job) in enumerate(rows):
        said = [scene, *words, *(word for step in job.steps for word in (step.action, step.target))]
        stem = re.sub(r"[^\w.-]+", "_", "_".join(word for word in said if word))
        stem = f"{stem}_{number}" if number and stem in {path.stem for path in found.values()} else stem
        found |= {(seed, number): made.npz / f"{stem}_{seed}.npz" for seed in made.job.seeds}
    return found


def _write_files(made: Order, result: baking.Result | CastResult) -> list[Path]:
    """Write the .blend and the takes' .npz files; return where. Raise SampError."""
    files = []
    if made.output:
        open_scene.save_copy(made.output)
        files.append(made.output)
    if made.npz is None:
        return files
    places = npz_paths(made)
    try:
        for key, owner, action in _baked(result):
            files.append(places[key])
            with atomic_write(files[-1]) as part:
                amass.write_amass(keyframes.read_motion(owner, action), part)
    except OSError as error:
        raise SampError(f"'{made.npz}' cannot be written ({error}); choose another --npz.") from error
    return files


def _baked(
    result: baking.Result | CastResult,
) -> Iterator[tuple[tuple[int, int], Any, Any]]:
    """Yield seed and number of each take, with its armature and Action."""
    if isinstance(result, CastResult):
        for number, own in result.actions.items():
            for seed, action in own.items():
                yield (seed, number), result.owners[number], action
        return
    for variant, action in zip(result.variants, result.actions, strict=True):
        yield (variant["seed"], 0), result.owner, action


def _write_report(path: Path | None, variants: Sequence[dict], errors: Sequence[dict]) -> bool:
    """Write the report, whole or not at all; return whether that worked."""
    if path is None:
        return True
    try:
        with atomic_write(path) as part:
            part.write_text(json.dumps(reporting.report(variants, errors), indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        _complain(f"The report '{path}' cannot be written ({error.strerror}); choose another --report.")
        return False
    return True


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _say(text: str) -> None:
    print(f"bake: {_printable(text)}", flush=True)


def _complain(text: str) -> None:
    line = " ".join(text.split())
    line = line if len(line) <= LONGEST_LINE else line[:LONGEST_LINE] + " ..."
    print(f"bake: {_printable(line)}", file=sys.stderr, flush=True)


def _printable(text: str) -> str:
    """Return the text without what no encoding has, such as half a surrogate pair from a JSON string."""
    return text.encode("utf-8", "replace").decode("utf-8")
