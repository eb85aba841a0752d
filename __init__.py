"""SAMP for Blender: entry point of the extension. Registers operators, user interface and shell command."""


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
