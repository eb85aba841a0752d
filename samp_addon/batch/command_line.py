"""The options of the batch, and the one parser behind the command line and the lines of a jobs file."""

from __future__ import annotations

import argparse
import functools
from collections.abc import Sequence
from typing import Any, NoReturn

from ..body import body_shape
from ..errors import UsageError
from ..methods import registry
from .console import FORMATS
from .farm import selection

UNITS = ("m", "cm", "mm", "in", "ft")
UP = ("Y", "Z")
ON_FAILURE = ("fail", "report")
VIEWS = ("page", "table")
FARM = ("jobs", "part", "lines", "on_failure", "relative_to", "progress", "merge", *VIEWS)
"""Options of the command line that a line of a jobs file cannot have."""

LONGEST_MESSAGE = 300
"""Characters of a message about an argument; a jobs file can hold a line of any length."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        text = message[:1].upper() + message[1:]
        raise UsageError((text if len(text) <= LONGEST_MESSAGE else text[:LONGEST_MESSAGE] + " ...") + ".")


def file_name(text: str) -> str:
    """Return the name of a file, for argparse."""
    if not text or "\0" in text:
        raise argparse.ArgumentTypeError("it needs the name of a file")
    return text


def shape_measure(text: str) -> tuple[str, float]:
    """Return name and value of a measure of the body, for argparse."""
    try:
        return body_shape.measure(text)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error).removesuffix(".")) from error


def parser() -> argparse.ArgumentParser:
    """Return the parser of all options. Its errors are UsageErrors; options left out are left out of the result."""
    made = _Parser(
        prog="bake.py",
        description="Bakes takes: a character walks to the furniture and sits down, as keyframes.",
        argument_default=argparse.SUPPRESS,
        allow_abbrev=False,
    )
    add = made.add_argument
    several = "; several in a row with commas between them, or the option again and again"
    add(
        "--scene",
        type=file_name,
        metavar="FILE",
        help=".blend, .glb, .gltf, .obj, .fbx or .usd; left out, the open file",
    )
    add("--units", choices=UNITS, metavar="UNIT", help=f"of an imported scene: {', '.join(UNITS)}")
    add("--up", choices=UP, metavar="AXIS", help="axis that points up in an imported scene: Y or Z")
    add("--action", action="append", metavar="ACTION", help=", ".join(registry.actions()) + several)
    add(
        "--target",
        action="append",
        metavar="NAME",
        help="object, or empty or collection that holds the furniture's parts; for several actions one each",
    )
    add(
        "--to",
        type=float,
        nargs="+",
        action="append",
        metavar="N",
        help="X Y Z [YAW]: where to walk or run, metres, degrees; again for each walk without a target",
    )
    add("--character", metavar="NAME", help="an SMPL-X armature; left out, the default human is made")
    add(
        "--shape",
        type=shape_measure,
        nargs="+",
        action="extend",
        metavar="NAME=VALUE",
        help=f"of the human that is made: {', '.join(body_shape.MEASURES)}, such as height=1.85 weight=90",
    )
    add("--start", type=float, nargs="+", metavar="N", help="X Y Z YAW: metres and degrees; yaw 0 faces -Y")
    add("--seed", type=int, metavar="N", help="seed of the first take (0)")
    add("--variants", type=int, metavar="K", help="number of takes, with seeds from N upward (1)")
    add("--hold", type=float, metavar="SECONDS", help="how long the action is held at the end (2)")
    add("--style", type=float, metavar="S", help="how much takes differ, 0 to 1 (0.1)")
    add("--speed", type=float, metavar="F", help="speed relative to captured motion, 0.5 to 2 (1)")
    add("--via", type=float, nargs="+", metavar="N", help="X Y Z [X Y Z ...]: places that the path passes")
    add(
        "--hand",
        action="append",
        metavar="SIDE=NAME",
        help="left or right hand on an object: SIDE=NAME[#VERTEX][:FIRST-LAST], frames; again for the other hand",
    )
    add("--path", metavar="CURVE", help="curve object that the path follows")
    add("--refine", action="store_true", help="run the optimisation on each take")
    methods = (
        f"{', '.join(registry.METHODS)} ({registry.DEFAULT}); for several actions one for all, or one each"
    )
    add("--method", action="append", metavar="METHOD", help=methods)
    add(
        "--cast",
        type=file_name,
        metavar="FILE",
        help="several characters in one take: a JSON list of objects with character, action, target, to, start, delay",
    )
    add(
        "--output",
        type=file_name,
        metavar="FILE",
        help=".blend with one Action for each take, the first one active",
    )
    add("--overwrite", action="store_true", help="let --output replace the scene's own file")
    add("--npz", type=file_name, metavar="DIR", help="folder for each take as AMASS SMPL-X .npz")
    add("--preview", type=file_name, metavar="DIR", help="folder for a picture of each take, 480 pixels wide")
    add(
        "--dataset",
        type=file_name,
        metavar="DIR",
        help="folder for joints, contacts and labels of each take as .npz, and for --frames",
    )
    add(
        "--frames",
        type=int,
        metavar="N",
        help="pictures of N moments of each take, with depth and objects, in --dataset",
    )
    add(
        "--camera",
        metavar="NAME",
        help="of --frames, and of a method that sees through one; left out, the scene's active one",
    )
    for method in registry.METHODS.values():
        _add_options(made, method)
    add("--report", type=file_name, metavar="FILE", help="JSON about what was made")
    add("--page", type=file_name, metavar="FILE", help="the report as a page (.html) with pictures, sortable")
    add("--table", type=file_name, metavar="FILE", help="all measures of the report as .csv or .parquet")
    add(
        "--jobs",
        type=file_name,
        metavar="FILE",
        help="many jobs: a JSON object of these options a line; done ones are skipped",
    )
    _add_farm_options(made)
    return made


def _add_farm_options(made: argparse.ArgumentParser) -> None:
    """Add the options for a jobs file that is done in pieces."""
    add = made.add_argument
    add(
        "--part",
        type=selection.part,
        metavar="I/N",
        help="of a jobs file, only the lines whose number is I modulo N; lines count from 1, I from 0 to N",
    )
    add("--lines", type=selection.span, metavar="FIRST-LAST", help="of a jobs file, only these lines")
    add(
        "--on-failure",
        dest="on_failure",
        choices=ON_FAILURE,
        metavar="fail|report",
        help="exit status where a line of a jobs file fails: 1, or 0 with the reason in the report only (fail)",
    )
    add(
        "--relative-to",
        dest="relative_to",
        type=file_name,
        metavar="DIR",
        help="folder, or a file in it, where relative names of a jobs file begin; left out, the current one",
    )
    add(
        "--progress",
        choices=FORMATS,
        metavar="FORMAT",
        help=f"also print progress as a render farm reads it: {', '.join(FORMATS)}",
    )
    add(
        "--merge",
        type=file_name,
        nargs="+",
        metavar="REPORT",
        help="join reports of parts, or folders of them, into --report; with --jobs, lines without one are errors",
    )


def _add_options(made: argparse.ArgumentParser, method: registry.Method) -> None:
    """Add a method's own options, once where two methods share one."""
    known = {flag for action in made._actions for flag in action.option_strings}
    for option in method.options:
        if option.flag not in known:
            made.add_argument(
                option.flag,
                dest=option.name,
                type=option.kind,
                nargs=len(option.metavar) if len(option.metavar) > 1 else None,
                action="append" if option.repeated else "store",
                metavar=option.metavar if len(option.metavar) > 1 else option.metavar[0],
                help=f"{option.help} ({method.name})",
            )


def parse(arguments: Sequence[str]) -> dict[str, Any]:
    """Return the options on a command line, without those left out. Raise UsageError."""
    return vars(current_parser().parse_args(list(arguments)))


def current_parser() -> argparse.ArgumentParser:
    """Return the parser, built once for the registered methods: a jobs file needs it for each line."""
    return _built_for(tuple((name, id(method)) for name, method in registry.METHODS.items()))


@functools.lru_cache(maxsize=1)
def _built_for(methods: tuple[tuple[str, int], ...]) -> argparse.ArgumentParser:
    """Return the parser. methods: what it depends on."""
    return parser()
