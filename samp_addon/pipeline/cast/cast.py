"""What is asked for: a cast, several characters that act in one scene at the same time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ...errors import UsageError
from ..job import LARGEST_SEED, MOST_VARIANTS, Job

MOST_MEMBERS = 64
LONGEST_DELAY = 3600.0  # seconds
APART = 7919
"""Between the seeds of two members of a cast: far enough for variants of both."""


@dataclass(frozen=True)
class Member:
    """One character of a cast.

    job: what it does. name: in messages, and that of a character that is made. delay: seconds after the cast's first
    frame before which it does not set off. targets: names of pieces of furniture of which the last action takes a
    free one; empty for the job's own target. look_at: name of the member or object that it looks at in the end, or
    empty. Raises UsageError for values that cannot be used.
    """

    job: Job
    name: str
    delay: float = 0.0
    targets: tuple[str, ...] = ()
    look_at: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.delay) and 0 <= self.delay <= LONGEST_DELAY):
            raise UsageError(
                f"'{self.name}': the delay is {self.delay:g}; choose from 0 to {LONGEST_DELAY:g} seconds."
            )


@dataclass(frozen=True)
class Cast:
    """Takes of several characters in one scene. seed, variants: as a Job's; refine: whether takes are refined.

    Raises UsageError for a cast without members or with too many, and where a character has two parts.
    """

    members: tuple[Member, ...]
    seed: int = 0
    variants: int = 1
    refine: bool = False

    def __post_init__(self) -> None:
        if not 1 <= len(self.members) <= MOST_MEMBERS:
            raise UsageError(f"The cast has {len(self.members)} members; list from 1 to {MOST_MEMBERS}.")
        if not 1 <= self.variants <= MOST_VARIANTS:
            raise UsageError(f"--variants is {self.variants}; choose from 1 to {MOST_VARIANTS}.")
        named = [member.job.character for member in self.members if member.job.character]
        for name in named:
            if named.count(name) > 1:
                raise UsageError(f"'{name}' is in the cast twice; give each character one entry.")

    @property
    def seeds(self) -> range:
        """The takes' seeds, from `seed` upward."""
        return range(self.seed, self.seed + self.variants)

    def member_seed(self, seed: int, number: int) -> int:
        """Return the seed of a member's own take in the cast's take of a seed."""
        own = self.members[number].job.seed
        shift = seed - self.seed
        return (own + shift if own != self.seed else seed + APART * number) % (LARGEST_SEED + 1)


def named(jobs: Sequence[Job], names: Sequence[str]) -> list[str]:
    """Return a name for each member: its own, its character's, or its number."""
    return [
        name or job.character or f"Character {number}"
        for number, (job, name) in enumerate(zip(jobs, names, strict=True), start=1)
    ]
