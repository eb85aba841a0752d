"""What a take depends on besides its job: the versions of program and packages, and the networks' weights."""

from __future__ import annotations

import functools
import platform
import tomllib
from importlib import metadata
from pathlib import Path
from typing import Any

from ..blender import compat

ROOT = Path(__file__).resolve().parents[2]
_PACKAGES = ("numpy", "scipy", "torch")


@functools.cache
def build() -> dict[str, Any]:
    """Return versions by name, and the SHA-256 of each weights file, for the report. Nothing is imported for it."""
    return {
        "program": _program(),
        "blender": compat.version(),
        "python": platform.python_version(),
        **{name: _version(name) for name in _PACKAGES},
        "platform": f"{platform.system()} {platform.machine()}",
        "weights": _weights(),
    }


def _program() -> str | None:
    try:
        return tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
    except (OSError, KeyError, tomllib.TOMLDecodeError):
        return None


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _weights() -> dict[str, str]:
    """Return the checksums stored beside the weights, by the file's path without its suffix."""
    folder = ROOT / "models" / "weights"
    files = sorted(folder.rglob("*.sha256"))
    return {
        path.relative_to(folder).with_suffix("").as_posix(): path.read_text(encoding="utf-8").split()[0]
        for path in files
    }
