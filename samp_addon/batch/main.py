"""The batch: jobs from a command line or a file, without a window. docs/batch.md tells how it is used."""

from __future__ import annotations

import json
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy

from .. import amass, dependencies
from ..atomic_file import atomic_write
from ..blender.actions import keyframes
from ..blender.scene import open_scene
from ..blender.takes import baking, reporting
from ..errors import SampError
from ..methods.take import Tools
from ..pipeline import job
from ..pipeline.job import Order, UsageError
from . import take_by_take
from .ledger import Ledger
from .saved_takes import KeptTakes

DONE, FAILED, UNUSABLE = 0, 1, 2


@dataclass
class Outcome:
    """What became of one order: the report's variants and errors, and the files written."""

    variants: list[dict] = field(default_factory=list)
    errors: list[dict] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)


def main(arguments: Sequence[str], tools: Tools | None = None) -> int:
    """Runs the batch; returns its exit status. Errors are one line on standard error."""
    try:
        options = job.parse(arguments)
        if "jobs" in options:
            return _many(options, tools)
        return _one(options, tools)
    except UsageError as error:
        _complain(str(error))
        return UNUSABLE
    except KeyboardInterrupt:
        _complain("Stopped.")
        return FAILED


def _one(options: Mapping[str, Any], tools: Tools | None) -> int:
    order = job.order(options)
    _usable(order)
    outcome = _carry_out(order, tools)
    for error in outcome.errors:
        _complain(error["message"])
    if not _write_report(order.report, outcome.variants, outcome.errors) or outcome.errors:
        return FAILED
    files = ", ".join(map(str, outcome.files)) or "the report"
    _say(f"Baked {_counted(len(outcome.variants), 'take')}: {files}")
    return DONE


def _many(options: Mapping[str, Any], tools: Tools | None) -> int:
    """All jobs of a file; what its ledger holds is not done again."""
    path = Path(options["jobs"])
    lines = _lines(path)
    shared = {name: value for name, value in options.items() if name not in ("jobs", "report")}
    report = Path(options["report"]) if "report" in options else None
    ledger, claimed = Ledger.beside(path), {}
    variants, errors = [], []
    for count, (number, text) in enumerate(lines, start=1):
        told = {"line": number}
        try:
            order = job.order(shared | _options(text))
            told["job"] = order.options()
            _usable(order)
            _claim(order, number, claimed)
            outcome = ledger.recall(order)
            state = "done before"
            if outcome is None:
                state = "done"
                kept = ledger.kept(order)
                outcome = _carry_out(order, tools, kept, f"{count}/{len(lines)} ")
                if not outcome.errors:
                    ledger.note(order, outcome.variants, outcome.files)
                    kept.forget()
                    _write_report(order.report, outcome.variants, [])
            else:
                outcome = Outcome(variants=outcome)
        except SampError as error:
            outcome = Outcome(errors=[{"message": str(error)}])
        for error in outcome.errors:
            state = "failed"
            _complain(f"Line {number}: {error['message']}")
        variants += [told | variant for variant in outcome.variants]
        errors += [told | error for error in outcome.errors]
        _say(f"{count}/{len(lines)} {state}")
        if not _write_report(report, variants, errors):
            return FAILED
    return FAILED if errors else DONE


def _carry_out(order: Order, tools: Tools | None, kept: KeptTakes | None = None, label: str = "") -> Outcome:
    """One order from its file to its files; what goes wrong is in the outcome. label: before each take's line."""
    try:
        with _quiet() as say:
            _open(order)
            result = take_by_take.run(
                bpy.context, order.job, tools, kept, lambda text: say(f"bake: {label}{text}\n")
            )
            files = [_save(order.output)] if order.output else []
            files += _export(order, result) if order.npz else []
    except SampError as error:
        return Outcome(errors=[{"message": str(error)}])
    except Exception as error:
        if told := dependencies.explain(error):
            return Outcome(errors=[{"message": told}])
        # Never a traceback on the screen; whoever mends the program finds it in the report.
        text = f"Something unexpected went wrong ({type(error).__name__}: {error}); please report it."
        return Outcome(errors=[{"message": " ".join(text.split()), "traceback": traceback.format_exc()}])
    errors = [{"seed": failure.seed, "message": failure.message} for failure in result.failures]
    return Outcome(result.variants, errors, files)


def _usable(order: Order) -> None:
    """Raises UsageError for what can be told before any work is done."""
    if order.scene is not None and not order.scene.is_file():
        raise UsageError(f"There is no file '{order.scene}'; name the scene to open with --scene.")
    if order.scene is None and not (bpy.data.filepath or _opened_by_blender()):
        raise UsageError("Name the scene to open with --scene FILE.")


def _opened_by_blender() -> bool:
    """Whether this is Blender with some scene of its own, rather than Python with the bpy module."""
    return bool(bpy.app.binary_path)


def _open(order: Order) -> None:
    if order.scene is not None:
        open_scene.open_scene(order.scene)
    elif bpy.data.filepath:
        # Afresh, so that no job finds what another one has made.
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)


def _save(path: Path) -> Path:
    """Writes the open file as .blend."""
    try:
        with atomic_write(path) as part:
            bpy.ops.wm.save_as_mainfile(filepath=str(part.absolute()), copy=True, check_existing=False)
    except (RuntimeError, OSError) as error:
        reason = str(error).strip().removeprefix("Error: ").rstrip(".")
        raise SampError(f"'{path}' cannot be written ({reason}); choose another --output.") from error
    return path


def npz_paths(order: Order) -> dict[int, Path]:
    """Where each seed's take goes, named after scene, action, target and seed."""
    scene = order.scene.stem if order.scene else Path(bpy.data.filepath or "untitled").stem
    words = [scene, *(word for step in order.job.steps for word in (step.action, step.target))]
    stem = re.sub(r"[^\w.-]+", "_", "_".join(word for word in words if word))
    return {seed: order.npz / f"{stem}_{seed}.npz" for seed in order.job.seeds}


def _export(order: Order, result: baking.Result) -> list[Path]:
    files = npz_paths(order)
    try:
        for variant, action in zip(result.variants, result.actions, strict=True):
            with atomic_write(files[variant["seed"]]) as part:
                amass.write_amass(keyframes.read_motion(result.owner, action), part)
    except OSError as error:
        raise SampError(f"'{order.npz}' cannot be written ({error}); choose another --npz.") from error
    return [files[variant["seed"]] for variant in result.variants]


def _claim(order: Order, number: int, claimed: dict) -> None:
    """Raises SampError if another job of the same file writes the same files with other options."""
    key = json.dumps(order.options(), sort_keys=True)
    files = [order.output] if order.output else []
    files += list(npz_paths(order).values()) if order.npz else []
    for path in files:
        line, other = claimed.setdefault(path.absolute(), (number, key))
        if other != key:
            raise SampError(f"'{path}' is written by line {line} already; name another file.")


def _lines(path: Path) -> list[tuple[int, str]]:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"The jobs file '{path}' cannot be read ({error}).") from error
    return [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]


def _options(text: str) -> dict[str, Any]:
    try:
        options = json.loads(text)
    except json.JSONDecodeError as error:
        raise SampError(f"This is not JSON ({error.msg} at column {error.colno}).") from error
    if not isinstance(options, dict):
        raise SampError('A job is a JSON object, such as {"scene": "room.blend", "action": "sit"}.')
    if "jobs" in options:
        raise SampError("A job cannot name another jobs file.")
    return options


def _write_report(path: Path | None, variants: Sequence[dict], errors: Sequence[dict]) -> bool:
    """Writes the report, whole or not at all; says whether that worked."""
    if path is None:
        return True
    try:
        with atomic_write(path) as part:
            part.write_text(json.dumps(reporting.report(variants, errors), indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        _complain(f"The report '{path}' cannot be written ({error.strerror}); choose another --report.")
        return False
    return True


@contextmanager
def _quiet() -> Iterator[Callable[[str], object]]:
    """Keeps what importers and Blender print off the two outputs, whose lines are read by scripts.

    Blender writes past Python, so the descriptors themselves are turned away. Yields what still writes to standard
    output.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(number) for number in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for number in (1, 2):
            os.dup2(nowhere, number)
        yield lambda text: os.write(kept[0], text.encode(sys.stdout.encoding or "utf-8", "replace"))
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for number, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, number)
            os.close(copy)
        os.close(nowhere)


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _say(text: str) -> None:
    print(f"bake: {text}", flush=True)


def _complain(text: str) -> None:
    print(f"bake: {' '.join(text.split())}", file=sys.stderr, flush=True)
