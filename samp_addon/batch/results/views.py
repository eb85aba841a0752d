"""Writes the views of a report that are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...errors import UsageError
from ..command_line import VIEWS
from . import page, table


def check(options: Mapping[str, Any]) -> None:
    """Raise UsageError for views that cannot be written, before any work is done."""
    if "page" in options and Path(options["page"]).suffix not in (".html", ".htm"):
        raise UsageError(f"--page is '{options['page']}'; name an .html file.")
    if "table" in options:
        table.check(Path(options["table"]))


def refuse(options: Mapping[str, Any], reason: str) -> None:
    """Raise UsageError if a view is asked for."""
    for name in VIEWS:
        if name in options:
            raise UsageError(f"The --{name} {reason}.")


def write(options: Mapping[str, Any], report: Mapping[str, Any]) -> None:
    """Write the page and the table of a report, where they are asked for. Raise SampError."""
    if "page" in options:
        page.write(Path(options["page"]), report)
    if "table" in options:
        table.write(Path(options["table"]), report)
