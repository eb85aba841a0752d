"""The methods by name. The command line, the panel, the batch and the report ask here.

A new method is a folder beside this file, whose `method.py` has a METHOD, and its name in FOLDERS. A method whose
weights are not there is left out.
"""

from __future__ import annotations

from importlib import import_module

from ..errors import UsageError
from .method import Method

FOLDERS = ("samp", "long_term", "scene_gan")
METHODS: dict[str, Method] = {
    method.name: method
    for method in (import_module(f".{folder}.method", __package__).METHOD for folder in FOLDERS)
    if method.installed()
}
DEFAULT = "samp"


def find(name: str) -> Method:
    """Return the method of this name. Raise UsageError where there is none."""
    try:
        return METHODS[name]
    except KeyError:
        raise UsageError(f"There is no method '{name}'; choose one of {', '.join(METHODS)}.") from None


def actions() -> tuple[str, ...]:
    """Return all actions that some method can be asked for, those of the first method first."""
    return tuple(dict.fromkeys(action for method in METHODS.values() for action in method.actions))
