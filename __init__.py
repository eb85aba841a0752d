"""SAMP for Blender: the extension's entry. Registers what an artist can press, and nothing else."""


def register() -> None:
    """Called by Blender when the extension is enabled. Imports no torch."""
    from . import operators
    from .samp_addon.ui import preferences, shell_command

    operators.register()
    preferences.register()
    shell_command.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    from . import operators
    from .samp_addon.ui import preferences, shell_command

    shell_command.unregister()
    preferences.unregister()
    operators.unregister()
