"""Motions as Actions: keyframes, notes in custom properties, and refinement of an Action.

Scripts outside of the repository use the functions below as ``actions.NAME``.
"""

PUBLISHED = ("activate_action", "read_motion", "write_motion")


def __getattr__(name: str) -> object:
    if name in PUBLISHED:
        from . import keyframes

        return getattr(keyframes, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
