"""The add-on's preferences: Python packages and how to install missing ones, the render farm, the keys."""

from __future__ import annotations

import functools
import sys

import bpy

from .. import dependencies
from ..dependencies import Package
from . import keys
from .farm import engine


class SAMP_AP_preferences(bpy.types.AddonPreferences):
    """Edit > Preferences > Add-ons > SAMP"""

    bl_idname = __package__.rsplit(".samp_addon", 1)[0]
    __annotations__ = engine.annotations()

    def draw(self, context: bpy.types.Context) -> None:
        found = _found()
        column = self.layout.column()
        column.label(text="Python Packages", icon="SCRIPT")
        for package, present, version in found:
            status = (version or "found") if present else f"missing, needed for {package.needed_for}"
            column.label(text=f"{package.distribution}: {status}", icon="CHECKMARK" if present else "ERROR")
        missing = [package for package, present, _ in found if not present]
        for line in advice(missing):
            column.label(text=line)
        if missing:
            column.operator("samp.copy_install_commands", icon="COPYDOWN")
        engine.draw(self.layout, self)
        keys.draw(self.layout, context)


def advice(missing: list[Package]) -> list[str]:
    """Return advice on missing packages, one line each; empty if none are missing."""
    if not missing:
        return []
    lines = [
        "Either install the zip of this add-on that has them: its name has the platform and no 'light' or 'bare'.",
        "Or copy the commands that install them, paste them into a terminal, and restart Blender.",
    ]
    if sys.platform == "linux" and any(package.module == "torch" for package in missing):
        lines.append("On Linux the commands install torch with GPU support, which takes several gigabytes.")
    return lines


def install_commands() -> str:
    """Return the commands that install missing packages into Blender's folder for script modules."""
    folder = bpy.utils.user_resource("SCRIPTS", path="modules")
    return "\n".join(dependencies.install_commands(sys.executable, folder, dependencies.missing()))


@functools.lru_cache(maxsize=1)
def _found() -> tuple[tuple[Package, bool, str], ...]:
    """Return package, presence and version. Cached: packages change only with a restart of Blender."""
    return tuple((package, package.present, package.version) for package in dependencies.PACKAGES)


def register() -> None:
    """Register the preferences."""
    _found.cache_clear()
    bpy.utils.register_class(SAMP_AP_preferences)


def unregister() -> None:
    """Unregister the preferences."""
    bpy.utils.unregister_class(SAMP_AP_preferences)
