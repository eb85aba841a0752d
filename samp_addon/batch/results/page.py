"""A report as a page that opens without a server: pictures, measures and warnings of all takes, sortable."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...atomic_file import atomic_write
from ...errors import SampError
from .table import Row, columns, rows

SHOWN = (
    "line", "scene", "action", "target", "seed", "success", "position_error_cm", "rotation_error_deg",
    "execution_time_s", "penetration_max_cm", "foot_slide_cm_s", "attempts", "warnings", "message",
)  # fmt: skip
"""Columns of the page; the table has all."""

UNITS = {"cm": "cm", "cm_s": "cm/s", "deg": "degrees", "s": "s"}
"""Units at the ends of the names of measures, and how the page writes them."""

DECIMALS = 1
"""Decimals of measures on the page; the table has all of them."""

FILES = ("scene", "output", "preview")
"""Columns that are names of files."""

_STYLE = """
body { font: 14px system-ui, sans-serif; margin: 1em; }
table { border-collapse: collapse; }
th { cursor: pointer; position: sticky; top: 0; background: #eee; }
th, td { border: 1px solid #ccc; padding: 3px 6px; text-align: left; vertical-align: top; }
td.number { text-align: right; }
tr.failed { background: #fdd; }
tr.warned { background: #ffd; }
img { max-width: 480px; display: block; }
"""

# Sort by a column at a click on its head, down and up by turns; rows without a value stay at the end.
_SCRIPT = """
for (const head of document.querySelectorAll("th")) {
  head.addEventListener("click", () => {
    const column = head.cellIndex, body = document.querySelector("tbody");
    const up = head.dataset.up = head.dataset.up === "1" ? "0" : "1";
    const value = (row) => row.cells[column].dataset.value;
    const compare = (a, b) => {
      const one = value(a), other = value(b);
      if (one === "" || other === "") return (one === "") - (other === "");
      const numbers = Number(one) - Number(other);
      const order = Number.isNaN(numbers) ? one.localeCompare(other) : numbers;
      return up === "1" ? order : -order;
    };
    body.append(...[...body.rows].sort(compare));
  });
}
"""


def write(path: Path, report: Mapping[str, Any]) -> None:
    """Write the page of a report. Raise SampError where the file cannot be written."""
    try:
        with atomic_write(path) as part:
            part.write_text(page(report, path.parent), encoding="utf-8")
    except OSError as error:
        raise SampError(f"The page '{path}' cannot be written ({error.strerror}).") from error


def page(report: Mapping[str, Any], folder: Path) -> str:
    """Return the page's HTML. folder: of the page, for links to files."""
    table = sorted(rows(report), key=lambda row: row.get("line", 0))
    known = columns(table)
    names = [name for name in SHOWN if name in known]
    if "preview" in known:
        names.insert(0, "preview")
    made, failed = len(report["variants"]), len(report["errors"])
    summary = f"{made} take{'' if made == 1 else 's'}, {failed} failed"
    heads = "".join(f"<th>{html.escape(_title(name))}</th>" for name in names)
    body = "\n".join(_row(row, names, folder) for row in table)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>SAMP: takes</title>'
        f"<style>{_STYLE}</style></head>\n<body><h1>{summary}</h1>\n"
        f"<table><thead><tr>{heads}</tr></thead>\n<tbody>\n{body}\n</tbody></table>\n"
        f"<script>{_SCRIPT}</script></body></html>\n"
    )


def _title(name: str) -> str:
    """Return the head of a column, with its unit."""
    for end in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{end}"):
            name = f"{name.removesuffix(f'_{end}')}, {UNITS[end]}"
            break
    return name.replace("_", " ").capitalize()


def _row(row: Row, names: Sequence[str], folder: Path) -> str:
    kind = "failed" if "message" in row else "warned" if row.get("warnings") else ""
    cells = "".join(_cell(name, row.get(name), folder) for name in names)
    return f'<tr class="{kind}">{cells}</tr>'


def _cell(name: str, value: object, folder: Path) -> str:
    if value is None or value == "":
        return '<td data-value=""></td>'
    text = html.escape(str(value), quote=True)
    if name == "preview":
        link = html.escape(_link(str(value), folder), quote=True)
        return f'<td data-value="{text}"><a href="{link}"><img src="{link}" loading="lazy"></a></td>'
    if name in FILES:
        return f'<td data-value="{text}" title="{text}">{html.escape(Path(str(value)).name)}</td>'
    if isinstance(value, bool):
        return f'<td data-value="{int(value)}">{"yes" if value else "no"}</td>'
    if isinstance(value, int | float):
        shown = f"{value:.{DECIMALS}f}" if isinstance(value, float) else value
        return f'<td class="number" data-value="{value}">{shown}</td>'
    return f'<td data-value="{text}">{text}</td>'


def _link(path: str, folder: Path) -> str:
    """Return the address of a file as seen from the page, so that both can be moved together."""
    try:
        relative = os.path.relpath(path, os.path.abspath(folder))
    except ValueError:  # another drive
        return Path(path).as_uri()
    return "/".join(_quoted(part) for part in Path(relative).parts)


def _quoted(part: str) -> str:
    from urllib.parse import quote

    return quote(part)
