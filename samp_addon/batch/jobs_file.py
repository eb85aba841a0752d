"""The jobs file: a JSON object a line. Each line becomes arguments for the parser of the command line."""

from __future__ import annotations

import argparse
import codecs
import json
import re
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

from ..errors import SampError, UsageError
from . import command_line

_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (codecs.BOM_UTF8, "utf-8-sig"),
)
_OWN = (*command_line.FARM, "help")  # options of the command line that a line cannot have


def lines(path: Path) -> list[tuple[int, str | SampError]]:
    """Return number and text of each line that is not empty; an error in place of a text that cannot be decoded.

    Raise UsageError where the file cannot be read. UTF-8 and UTF-16, with or without a byte-order mark.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"The jobs file '{path}' cannot be read ({error.strerror}).") from error
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), None)
    if encoding is None and b"\0" in data[:4]:
        encoding = "utf-16-le" if data[1:2] == b"\0" else "utf-16-be"
    if encoding not in (None, "utf-8-sig"):
        try:
            return _numbered(data.decode(encoding).encode("utf-8"))
        except UnicodeDecodeError as error:
            raise UsageError(f"The jobs file '{path}' is no sound {encoding} ({error.reason}).") from error
    return _numbered(data.removeprefix(codecs.BOM_UTF8))


def _numbered(data: bytes) -> list[tuple[int, str | SampError]]:
    found: list[tuple[int, str | SampError]] = []
    for number, line in enumerate(re.split(rb"\r\n|\n|\r", data), start=1):
        if not line.strip():
            continue
        try:
            found.append((number, line.decode("utf-8")))
        except UnicodeDecodeError as error:
            found.append((number, SampError(f"This line is not UTF-8 (byte {error.start + 1}).")))
    return found


def options(text: str, shared: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parsed options of a line, over those that all lines share. Raise SampError.

    A null takes the option's default, whatever the lines share.
    """
    values = _object(text)
    left_out = {name for name, value in values.items() if value is None}
    # The entries of a cast are no arguments: each is parsed for itself, see cast_entries.py.
    cast = {"cast": values.pop("cast")} if isinstance(values.get("cast"), list) else {}
    given = parsed(values) | cast
    for name, value in values.items():
        if value is False and isinstance(_switches().get(name), argparse._StoreTrueAction):
            left_out.add(name)
    return {name: value for name, value in shared.items() if name not in left_out} | given


def parsed(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parsed options of a JSON object. Raise UsageError."""
    return command_line.parse(arguments(values))


def arguments(values: Mapping[str, Any]) -> list[str]:
    """Return a line's values as arguments of the command line. Raise UsageError for values of another kind."""
    known = _switches()
    unknown = sorted(set(values) - set(known))
    if unknown:
        name = unknown[0] if len(unknown[0]) < 40 else unknown[0][:40] + " ..."
        raise UsageError(f"There is no option '{name}'; use {', '.join(sorted(known))}.")
    made: list[str] = []
    for name, value in values.items():
        if value is not None:
            made += _argument(known[name], value)
    return made


def _switches() -> dict[str, argparse.Action]:
    """Return the parser's options by the name that a line has for them."""
    return {
        action.dest: action for action in command_line.current_parser()._actions if action.dest not in _OWN
    }


def _argument(switch: argparse.Action, value: Any) -> list[str]:
    """Return one value as arguments; a list of values as a repeated option where it may be repeated."""
    flag = switch.option_strings[0]
    if isinstance(switch, argparse._StoreTrueAction):
        if not isinstance(value, bool):
            raise _unusable(flag, value)
        return [flag] if value else []
    if flag == "--shape" and isinstance(value, dict):
        value = [
            f"{name}={part if isinstance(part, str) else _number(flag, part)}" for name, part in value.items()
        ]
    if switch.nargs is None:
        repeated = isinstance(switch, argparse._AppendAction) and isinstance(value, list)
        # With an equals sign, for a name may begin with a dash.
        return [f"{flag}={_text(switch, flag, part)}" for part in (value if repeated else [value])]
    occurrences = [value]
    if isinstance(value, list) and any(isinstance(part, list) for part in value):
        repeated = isinstance(switch, argparse._AppendAction)
        occurrences = value if repeated else [_flat(flag, value)]
    made = []
    for numbers in occurrences:
        made += [
            flag,
            *(_text(switch, flag, v) for v in (numbers if isinstance(numbers, list) else [numbers])),
        ]
    return made


def _flat(flag: str, places: list) -> list:
    """Return a list of places as one list of numbers, for the option that takes several in a row."""
    if flag != "--via" or not all(isinstance(place, list) for place in places):
        raise _unusable(flag, places)
    return [number for place in places for number in place]


def _text(switch: argparse.Action, flag: str, value: Any) -> str:
    """Return one value as the text that its option takes."""
    if switch.type in (int, float):
        return _number(flag, value)
    if not isinstance(value, str):
        raise _unusable(flag, value)
    return value


def _number(flag: str, value: Any) -> str:
    """Return a number as text. Raise UsageError for anything else."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise _unusable(flag, value)
    return _digits(value)


def _digits(number: float) -> str:
    """Return a number without an exponent, which argparse takes for the name of an option after a minus sign."""
    if isinstance(number, float) and number.is_integer():
        return str(int(number))
    return str(number) if isinstance(number, int) else f"{Decimal(repr(number)):f}"


def _unusable(flag: str, value: Any) -> UsageError:
    text = json.dumps(value)
    return UsageError(f"{flag} cannot be {text if len(text) <= 60 else text[:60] + ' ...'}.")


def _object(text: str) -> dict[str, Any]:
    """Return the JSON object of a line. Raise SampError."""
    try:
        values = json.loads(text)
    except json.JSONDecodeError as error:
        raise SampError(f"This is not JSON ({error.msg} at column {error.colno}).") from error
    except (ValueError, RecursionError) as error:
        raise SampError(f"This JSON cannot be read ({_reason(error)}).") from error
    if not isinstance(values, dict):
        raise SampError('A job is a JSON object, such as {"scene": "room.blend", "action": "sit"}.')
    if "jobs" in values:
        raise SampError("A job cannot name another jobs file.")
    return values


def _reason(error: Exception) -> str:
    return "its lists are nested too deeply" if isinstance(error, RecursionError) else "a number is too long"
