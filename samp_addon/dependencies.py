"""The Python packages that the add-on needs and Blender does not ship: presence, versions, and error messages.

Packages are not imported to check for them, which keeps the check fast enough for a panel.
"""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Sequence
from dataclasses import dataclass

PREFERENCES = "Edit > Preferences > Add-ons > SAMP"


@dataclass(frozen=True)
class Package:
    """A Python package.

    module: name for imports. distribution: name for pip. needed_for: what does not work without it.
    """

    module: str
    distribution: str
    needed_for: str

    @property
    def present(self) -> bool:
        """Whether Python finds the package."""
        return importlib.util.find_spec(self.module) is not None

    @property
    def version(self) -> str:
        """The installed version; empty where the package is missing or has no metadata."""
        from importlib import metadata  # slow to import; this module is loaded at registration

        try:
            return metadata.version(self.distribution) if self.present else ""
        except metadata.PackageNotFoundError:
            return ""


# The wheels in the release zips are listed in release/wheels.toml.
PACKAGES = (
    Package("scipy", "scipy", "navmesh, voxels, goals and measures"),
    Package("torch", "torch", "Sit Here, Lie Here, Walk Here, Sample Goals and Refine"),
    Package("safetensors", "safetensors", "reading the networks' weights"),
    Package("typing_extensions", "typing_extensions", "torch"),
    Package("packaging", "packaging", "safetensors"),
)


def load_torch() -> None:
    """Import torch; called from a separate thread, Blender's window stays responsive.

    An import holds Python's global lock while the system links the library, for half a second and more. Linking
    through ctypes releases the lock, and the import then finds the library already loaded.
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
    """Return the packages that are not installed."""
    return [package for package in PACKAGES if not package.present]


def install_commands(python: str, folder: str, packages: Sequence[Package]) -> list[str]:
    """Return shell commands that install packages into a folder on the path of Blender's Python."""
    names = [package.distribution for package in packages]
    install = f'"{python}" -m pip install --target "{folder}"'
    lines = [] if importlib.util.find_spec("pip") else [f'"{python}" -m ensurepip']
    if "torch" in names:
        lines.append(f"{install} torch")
    # Without dependencies: that would be numpy, and a second copy would clash with Blender's own.
    others = " ".join(name for name in names if name != "torch")
    return [*lines, f"{install} --no-deps {others}"] if others else lines


def explain(error: BaseException) -> str | None:
    """Return the message for an error caused by a missing or broken package, or None for other errors."""
    named = getattr(error, "name", None) or ""
    known = {package.module for package in PACKAGES}
    if isinstance(error, ModuleNotFoundError) and named.split(".")[0] in known:
        return f"The Python package '{named.split('.')[0]}' is missing; {PREFERENCES} explains how to add it."
    if isinstance(error, ImportError | OSError):
        broken = known & set(_importing(error))
        if broken:
            name = sorted(broken)[0]
            reason = " ".join(str(error).split())
            return (
                f"The Python package '{name}' cannot be loaded ({reason}); see {PREFERENCES} to reinstall it."
            )
    return None


def _importing(error: BaseException) -> list[str]:
    """Return the packages whose module level was executing when an error was raised, as while an import fails."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    return [
        str(frame.f_globals.get("__name__", "")).split(".")[0]
        for frame in frames
        if frame.f_code.co_name == "<module>"
    ]
