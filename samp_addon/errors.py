"""Errors whose text is shown to the artist."""

from __future__ import annotations


class SampError(Exception):
    """A problem that the artist can solve. The text is one sentence that says what to do."""


class PathError(SampError):
    """There is no path from the start to the goal."""


class NoPlaceError(SampError):
    """The object has no place to sit or lie."""


class RolloutError(SampError):
    """The rollout did not reach the goal."""


class UsageError(SampError):
    """Arguments that cannot be used, whatever the scene holds."""
