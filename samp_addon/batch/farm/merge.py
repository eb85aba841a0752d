"""Joins the reports of parts into one."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...blender.takes.reporting import SCHEMA_VERSION
from ...errors import UsageError
from .. import jobs_file


@dataclass
class _Result:
    """What became of one line: the report's entries. A line with errors, or without anything, is not done."""

    variants: list[dict] = field(default_factory=list)
    errors: list[dict] = field(default_factory=list)

    @property
    def done(self) -> bool:
        return bool(self.variants) and not self.errors


def merge(reports: Sequence[Path], jobs: Path | None = None) -> dict[str, Any]:
    """Return the report of all lines. Raise UsageError for a report or jobs file that cannot be read.

    reports: files, and folders whose `.json` files are meant. Of several results of a line, the newest one counts,
    and one that is done counts over one that failed. jobs: the jobs file; its lines that no report knows become
    errors, and lines that it does not have are left out.
    """
    files = sorted(dict.fromkeys(_files(reports)), key=lambda path: path.stat().st_mtime_ns)
    results: dict[int, _Result] = {}
    repetitions: dict[int, dict] = {}
    alone = _Result()
    builds: list[dict] = []
    for content in map(_read, files):
        builds += [build for build in content.get("builds", []) if build not in builds]
        repetitions |= {entry["line"]: entry for entry in content.get("repetitions", [])}
        for line, result in _by_line(content).items():
            if line is None:
                alone.variants += result.variants
                alone.errors += result.errors
            elif line not in results or result.done or not results[line].done:
                results[line] = result
    for line, entry in repetitions.items():
        results.setdefault(line, _repeated(entry, results.get(entry["repeats"])))
    if jobs is not None:
        results = _of_jobs(results, jobs)
    rows = [alone, *(results[line] for line in sorted(results))]
    return {
        "schema_version": SCHEMA_VERSION,
        "variants": [variant for row in rows for variant in row.variants],
        "errors": [error for row in rows for error in row.errors],
        "builds": builds,
    }


def _files(reports: Iterable[Path]) -> Iterable[Path]:
    """Yield the report files. Raise UsageError for a name that is neither a file nor a folder."""
    for path in reports:
        if path.is_dir():
            yield from sorted(file for file in path.glob("*.json") if not file.name.startswith("."))
        elif path.is_file():
            yield path
        else:
            raise UsageError(f"There is no report '{path}'; name the reports of the parts with --merge.")


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"The report '{path}' cannot be read; run its part again.") from error
    if not isinstance(content, dict) or content.get("schema_version") != SCHEMA_VERSION:
        raise UsageError(f"'{path}' is no report of this version (schema {SCHEMA_VERSION}).")
    return content


def _by_line(content: Mapping[str, Any]) -> dict[int | None, _Result]:
    found: dict[int | None, _Result] = {}
    for kind in ("variants", "errors"):
        for entry in content.get(kind, []):
            getattr(found.setdefault(entry.get("line"), _Result()), kind).append(entry)
    return found


def _repeated(entry: Mapping[str, Any], first: _Result | None) -> _Result:
    """Return the result of a line that repeats another one's job."""
    own = {name: entry[name] for name in ("line", "job")}
    if first is None:
        message = f"This line repeats line {entry['repeats']}, which is in no report."
        return _Result(errors=[own | {"message": message}])
    return _Result([row | own for row in first.variants], [row | own for row in first.errors])


def _of_jobs(results: Mapping[int, _Result], jobs: Path) -> dict[int, _Result]:
    """Return the results of the lines of a jobs file."""
    missing = "This line is in no report; run its part."
    return {
        line: results.get(line) or _Result(errors=[{"line": line, "message": missing}])
        for line, _ in jobs_file.lines(jobs)
    }
