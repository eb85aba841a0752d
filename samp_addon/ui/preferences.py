"""The add-on's preferences: which Python packages are there, and how to add those that are not."""

from __future__ import annotations

import functools
import sys

import bpy

from .. import dependencies
from ..dependencies import Package


class SAMP_AP_preferences(bpy.types.AddonPreferences):
    """Shown under Edit > Preferences > Add-ons > SAMP."""

    bl_idname = __package__.rsplit(".samp_addon", 1)[0]

    def draw(self, context: bpy.types.Context) -> None:
        found = _found()
        column = self.layout.column()
        column.label(text="Python packages", icon="SCRIPT")
        for package, present, version in found:
            told = (version or "found") if present else f"missing: without it no {package.needed_for}"
            column.label(text=f"{package.distribution}: {told}", icon="CHECKMARK" if present else "ERROR")
        absent = [package for package, present, _ in found if not present]
        for line in advice(absent):
            column.label(text=line)
        if absent:
            column.operator("samp.copy_install_commands", icon="COPYDOWN")


def advice(absent: list[Package]) -> list[str]:
    """What to do about missing packages, a line each; nothing where none is missing."""
    if not absent:
        return []
    lines = [
        "Either install the zip of this add-on that holds them: its name has the platform and no 'light' or 'bare'.",
        "Or copy the commands that add them, paste them into a terminal, and start Blender again.",
    ]
    if sys.platform == "linux" and any(package.module == "torch" for package in absent):
        lines.append("On Linux that brings the torch for graphics cards, several gigabytes large.")
    return lines


def install_commands() -> str:
    """The lines that add the missing packages where Blender looks for modules of scripts."""
    folder = bpy.utils.user_resource("SCRIPTS", path="modules")
    return "\n".join(dependencies.install_commands(sys.executable, folder, dependencies.missing()))


@functools.lru_cache(maxsize=1)
def _found() -> tuple[tuple[Package, bool, str], ...]:
    """Looked for once: packages come and go only with a new start of Blender."""
    return tuple((package, package.present, package.version) for package in dependencies.PACKAGES)


def register() -> None:
    """Shows the preferences."""
    _found.cache_clear()
    bpy.utils.register_class(SAMP_AP_preferences)


def unregister() -> None:
    """Takes them away."""
    bpy.utils.unregister_class(SAMP_AP_preferences)
