"""SAMP for Blender: the extension's entry. Registers what an artist can press, and nothing else."""


def register() -> None:
    """Called by Blender when the extension is enabled. Imports no torch."""
    from . import operators
    from .samp_addon.blender import command, preferences

    operators.register()
    preferences.register()
    command.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    from . import operators
    from .samp_addon.blender import command, preferences

    command.unregister()
    preferences.unregister()
    operators.unregister()
