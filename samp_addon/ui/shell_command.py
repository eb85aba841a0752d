"""`blender --command samp OPTIONS`: the batch of the installed extension, with the options of bake.py."""

from __future__ import annotations

import atexit
import sys

import bpy

from .. import dependencies

NAME = "samp"
_registered: list[object] = []


def run(arguments: list[str]) -> int:
    """Run the batch and return its exit status."""
    try:
        from ..batch import main
    except ImportError as error:
        print(f"bake: {dependencies.explain(error) or error}", file=sys.stderr)
        return 2
    try:
        return main.main(arguments)
    except SystemExit as stop:  # --help; Blender reports an exception as a crash of the command
        return int(stop.code or 0)


def register() -> None:
    """Register the command."""
    _registered.append(bpy.utils.register_cli_command(NAME, run))
    # Blender 4.2 to 4.5 crash at exit if a Python command is still registered.
    atexit.register(unregister)


def unregister() -> None:
    """Unregister the command."""
    atexit.unregister(unregister)
    while _registered:
        bpy.utils.unregister_cli_command(_registered.pop())
