"""The Python packages that the program needs and Blender does not ship: which are there, and what to say if not.

Nothing is imported to find out, so asking is quick enough for a panel.
"""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Sequence
from dataclasses import dataclass

WHERE = "Edit > Preferences > Add-ons > SAMP"


@dataclass(frozen=True)
class Package:
    """One package. module: as it is imported. distribution: as it is installed. serves: what does not work without."""

    module: str
    distribution: str
    serves: str

    @property
    def present(self) -> bool:
        """Whether Python would find it."""
        return importlib.util.find_spec(self.module) is not None

    @property
    def version(self) -> str:
        """Its version, empty where it is missing or does not tell."""
        from importlib import metadata  # slow to import, and this module is read at registration

        try:
            return metadata.version(self.distribution) if self.present else ""
        except metadata.PackageNotFoundError:
            return ""


# The zips' wheels are listed in release/wheels.toml.
PACKAGES = (
    Package("scipy", "scipy", "navmesh, voxels, goals and measures"),
    Package("torch", "torch", "Sit Here, Lie Here, Walk Here, Sample Goals and Refine"),
    Package("safetensors", "safetensors", "reading the networks' weights"),
    Package("typing_extensions", "typing_extensions", "torch"),
    Package("packaging", "packaging", "safetensors"),
)


def load_torch() -> None:
    """Imports torch. From a thread of its own, Blender's window goes on meanwhile.

    An import holds Python's lock while the system links the library, half a second and more; called through ctypes,
    the system does that without the lock, and the import finds it done.
    """
    import ctypes
    import os
    from pathlib import Path

    if "torch" in sys.modules:
        return
    found = importlib.util.find_spec("torch")
    folder = Path(found.origin).parent / "lib" if found and found.origin else Path()
    for name in ("libtorch_python.so", "libtorch_python.dylib"):
        if (folder / name).exists():
            link = ctypes.CDLL(None).dlopen
            link.restype, link.argtypes = ctypes.c_void_p, (ctypes.c_char_p, ctypes.c_int)
            link(str(folder / name).encode(), os.RTLD_NOW | os.RTLD_LOCAL)
    import torch  # noqa: F401


def missing() -> list[Package]:
    """The packages that are not there."""
    return [package for package in PACKAGES if not package.present]


def install_commands(python: str, folder: str, packages: Sequence[Package]) -> list[str]:
    """The lines for a terminal that put packages into a folder that Blender's Python looks into."""
    names = [package.distribution for package in packages]
    install = f'"{python}" -m pip install --target "{folder}"'
    lines = [] if importlib.util.find_spec("pip") else [f'"{python}" -m ensurepip']
    if "torch" in names:
        lines.append(f"{install} torch")
    # Without what they ask for: that is numpy, and a second one beside Blender's own would clash with it.
    others = " ".join(name for name in names if name != "torch")
    return [*lines, f"{install} --no-deps {others}"] if others else lines


def sentence(error: BaseException) -> str | None:
    """What to tell the artist where an error comes of a package that is missing or broken, else None."""
    named = getattr(error, "name", None) or ""
    known = {package.module for package in PACKAGES}
    if isinstance(error, ModuleNotFoundError) and named.split(".")[0] in known:
        return f"The Python package '{named.split('.')[0]}' is missing; {WHERE} tells how to add it."
    if isinstance(error, ImportError | OSError):
        broken = known & set(_importing(error))
        if broken:
            name = sorted(broken)[0]
            reason = " ".join(str(error).split())
            return f"The Python package '{name}' cannot be loaded ({reason}); install it again: {WHERE} tells how."
    return None


def _importing(error: BaseException) -> list[str]:
    """The packages whose own module level was running when an error was raised: one that failed to load."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    return [
        str(frame.f_globals.get("__name__", "")).split(".")[0]
        for frame in frames
        if frame.f_code.co_name == "<module>"
    ]
