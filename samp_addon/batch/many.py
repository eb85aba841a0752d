"""The lines of a jobs file, one after the other: all of them, or those of one part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..blender.scene import open_scene
from ..blender.takes import reporting
from ..errors import SampError, UsageError
from ..pipeline.driver import Toolbox
from . import command_line, jobs_file, memory, report_file
from .carry_out import Outcome, Place, carry_out, require_scene
from .console import Console
from .farm import stopping
from .farm.claims import Claims, Line
from .farm.selection import Selection
from .order import Order, order
from .report_file import ReportFile
from .resuming.ledger import Ledger


@dataclass(frozen=True)
class Tally:
    """What became of a run: its report, how many lines failed, and why the first one of them did."""

    report: Mapping[str, Any]
    failed: int
    reason: str = ""


def bake_lines(
    options: Mapping[str, Any], tools: Toolbox | None = None, console: Console | None = None
) -> Tally:
    """Carry out the lines of a jobs file; what its ledger holds is not done again.

    options: parsed ones of the command line, with `jobs`. Raise UsageError where they cannot be used, and SampError
    where the report cannot be written.
    """
    console = console or Console()
    selection, path = _selection(options), Path(options["jobs"])
    lines = jobs_file.lines(path)
    chosen = [line for line in lines if line[0] in selection]
    report = ReportFile(Path(options["report"]) if "report" in options else None, selection)
    run = _Run.over(path, lines, chosen, options, tools, console)
    failed, reason = 0, ""
    for index, (number, text) in enumerate(chosen):
        stopping.check()
        place = Place(index, len(chosen), f"{index + 1}/{len(chosen)} ")
        console.advance(index / len(chosen), f"{place.label}line {number}")
        entry, outcome, state = run.line(number, text, place)
        if outcome.errors:
            state, failed = "failed", failed + 1
            reason = reason or f"Line {number}: {outcome.errors[0]['message']}"
        for error in outcome.errors:
            console.complain(f"Line {number}: {error['message']}")
        report.variants += [entry | variant for variant in outcome.variants]
        report.errors += [entry | error for error in outcome.errors]
        report.repetitions += [entry] if "repeats" in entry else []
        console.say(f"{place.label}{state}")
        report.update(last=index + 1 == len(chosen))
    if not chosen:
        report.update(last=True)
    console.advance(1.0, f"{len(chosen) - failed} of {len(chosen)} lines done")
    return Tally(report.content(), failed, reason)


def _selection(options: Mapping[str, Any]) -> Selection:
    """Return which lines are asked for. Raise UsageError for two answers."""
    if "part" in options and "lines" in options:
        raise UsageError("Use --part or --lines, not both.")
    return options.get("part") or options.get("lines") or Selection()


@dataclass
class _Run:
    """One run over lines of a jobs file.

    chosen: numbers of its lines. opened: the file that was open at its start.
    """

    shared: Mapping[str, Any]
    ledger: Ledger
    claims: Claims
    chosen: frozenset[int]
    opened: Path | None
    tools: Toolbox | None
    console: Console = field(default_factory=Console)

    @classmethod
    def over(
        cls,
        path: Path,
        lines: Sequence[Line],
        chosen: Sequence[Line],
        options: Mapping[str, Any],
        tools: Toolbox | None,
        console: Console,
    ) -> _Run:
        """Return the run over some lines of a jobs file."""
        own = (*command_line.FARM, "report")
        shared = {name: value for name, value in options.items() if name not in own}
        opened, numbers = open_scene.open_file(), frozenset(number for number, _ in chosen)
        claims = Claims(lines, shared, opened, lambda text: _parsed(text, shared, opened))
        ledger = Ledger.beside(path, numbers, _selection(options))
        return cls(shared, ledger, claims, numbers, opened, tools, console)

    def line(self, number: int, text: str | SampError, place: Place) -> tuple[dict, Outcome, str]:
        """Return the report's entry of a line, its outcome, and what to print of it."""
        entry: dict[str, Any] = {"line": number}
        try:
            if isinstance(text, SampError):
                raise text
            made = order(jobs_file.options(text, self.shared), self.opened)
            entry["job"] = made.options()
            require_scene(made)
            first = self.claims.first_line(number, made)
            variants = self.ledger.recall(made)
            if variants is not None:
                return entry, Outcome(variants=variants), "done before"
            if first not in self.chosen:
                return entry | {"repeats": first}, Outcome(), f"repeats line {first}"
            return entry, self._carried_out(made, place), "done"
        except SampError as error:
            return entry, Outcome(errors=[{"message": str(error)}]), "failed"

    def _carried_out(self, made: Order, place: Place) -> Outcome:
        saved = self.ledger.saved(made)
        outcome = carry_out(made, self.tools, self.console, saved, place)
        memory.give_back()
        if not outcome.errors:
            self.ledger.record(made, outcome.variants, outcome.files)
            saved.forget()
            report_file.write(made.report, reporting.report(outcome.variants))
        return outcome


def _parsed(text: str, shared: Mapping[str, Any], opened: Path | None) -> Order | None:
    """Return the order of a line, or None where it cannot be done."""
    try:
        made = order(jobs_file.options(text, shared), opened)
        require_scene(made)
    except SampError:
        return None
    return made
