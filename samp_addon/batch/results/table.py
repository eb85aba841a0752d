"""All measures of a report as a table: one row for each take and each failure."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...atomic_file import atomic_write
from ...errors import SampError, UsageError

FORMATS = (".csv", ".parquet")
FIRST = (
    "line",
    "scene",
    "action",
    "target",
    "method",
    "seed",
    "action_name",
    "npz",
    "output",
    "preview",
    "dataset",
    "frames",
)
"""Columns at the left; the measures follow, and then warnings and message."""

_PLAIN = ("frame_start", "frame_end", "fps", "interaction_start", "attempts")

Row = dict[str, Any]


def rows(report: Mapping[str, Any]) -> list[Row]:
    """Return the rows of a report, takes first. A name that a row lacks is not known of it."""
    return [_take(entry, report) for entry in report["variants"]] + [
        _failure(entry, report) for entry in report["errors"]
    ]


def columns(table: Sequence[Row]) -> list[str]:
    """Return the names of all columns, in order."""
    names = dict.fromkeys(name for row in table for name in row)
    last = ("warnings", "message")
    middle = [name for name in names if name not in (*FIRST, *last)]
    return [name for name in (*FIRST, *middle, *last) if name in names]


def check(path: Path) -> None:
    """Raise UsageError for a name of another kind, and where the package for Parquet is missing."""
    if path.suffix not in FORMATS:
        raise UsageError(f"--table is '{path}'; name a .csv or .parquet file.")
    if path.suffix == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError as error:
            raise UsageError(
                "The Python package 'pyarrow' is missing; install it for .parquet, or write a .csv."
            ) from error


def write(path: Path, report: Mapping[str, Any]) -> None:
    """Write the table of a report. Raise SampError where the file cannot be written."""
    table = rows(report)
    names = columns(table)
    try:
        with atomic_write(path) as part:
            (_write_csv if path.suffix == ".csv" else _write_parquet)(part, names, table)
    except OSError as error:
        raise SampError(f"The table '{path}' cannot be written ({error.strerror}).") from error


def _write_csv(path: Path, names: Sequence[str], table: Sequence[Row]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(table)


def _write_parquet(path: Path, names: Sequence[str], table: Sequence[Row]) -> None:
    import pyarrow
    import pyarrow.parquet

    content = {name: pyarrow.array([row.get(name) for row in table]) for name in names}
    pyarrow.parquet.write_table(pyarrow.table(content), path)


def _job(entry: Mapping[str, Any], report: Mapping[str, Any]) -> Row:
    """Return what a row knows of its job: the entry's own, or the only one of the report."""
    job = entry.get("job") or report.get("job") or {}
    return {name: job[name] for name in ("scene", "output") if job.get(name) is not None}


def _take(entry: Mapping[str, Any], report: Mapping[str, Any]) -> Row:
    own = {name: entry[name] for name in (*FIRST, *_PLAIN) if entry.get(name) is not None}
    measures = {name: value for name, value in entry.get("metrics", {}).items() if _is_plain(value)}
    return _job(entry, report) | own | measures | {"warnings": " ".join(entry.get("warnings", []))}


def _failure(entry: Mapping[str, Any], report: Mapping[str, Any]) -> Row:
    job = entry.get("job") or report.get("job") or {}
    known = {name: job[name] for name in ("action", "target", "method", "seed") if job.get(name) is not None}
    own = {name: entry[name] for name in ("line", "seed") if entry.get(name) is not None}
    return _job(entry, report) | known | own | {"message": entry["message"]}


def _is_plain(value: object) -> bool:
    return value is None or isinstance(value, bool | int | float | str)
