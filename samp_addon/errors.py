"""The one kind of error that reaches the artist."""

from __future__ import annotations


class SampError(Exception):
    """Something the artist can mend. Its text is one sentence that says what to do."""


class PathError(SampError):
    """No way from the start to the goal."""


class RolloutError(SampError):
    """The networks did not bring the character to the goal."""


class UsageError(SampError):
    """Arguments that cannot be used, whatever the scene holds."""
