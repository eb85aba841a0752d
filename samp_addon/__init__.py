"""The program: everything between an artist's scene and a finished Action. See docs/architecture.md."""

import importlib

PUBLISHED = {"amass": "body.amass"}
"""Modules by the names under which scripts outside of the repository import them."""


def __getattr__(name: str) -> object:
    if name in PUBLISHED:
        return importlib.import_module(f".{PUBLISHED[name]}", __package__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
