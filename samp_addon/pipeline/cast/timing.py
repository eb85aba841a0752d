"""When each member of a cast sets off, so that no two bodies meet: prioritised planning in time.

A member that has been scheduled is a moving obstacle to those after it. Every body is there all the time: before it
sets off it stands at its start, after its last frame it keeps its last pose. Times are frames at a common rate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...body.balls import Track
from ...evaluation.between_bodies import conflicts

CLEARANCE = 0.03
"""Metres between the balls of two bodies; these may lie 2 cm under the skin."""

Pairs = Mapping[tuple[int, int], np.ndarray]
"""Flags (Ta, Tb) of the frames in which members a < b would be in each other, see between_bodies.conflicts."""


@dataclass(frozen=True)
class Schedule:
    """starts: the frame in which each member sets off. stuck: members that meet others whenever they set off, each
    with one that it meets; their starts are those in which they meet others for the shortest time."""

    starts: tuple[int, ...]
    stuck: Mapping[int, int]


def pairs(tracks: Sequence[Track], known: Pairs | None = None) -> Pairs:
    """Return the conflicts of all pairs of bodies. known: pairs that need not be computed again."""
    found = dict(known or {})
    for b in range(len(tracks)):
        for a in range(b):
            if (a, b) not in found:
                found[a, b] = conflicts(tracks[a], tracks[b], CLEARANCE)
    return found


def schedule(
    conflicts_of: Pairs,
    lengths: Sequence[int],
    earliest: Sequence[int],
    longest_wait: int,
    fixed: Mapping[int, int] | None = None,
) -> Schedule:
    """Return a schedule in which each member waits as little as those before it allow.

    earliest: the first frame in which each member may set off; those with an earlier one go first, then those listed
    first. longest_wait: frames that a member may wait at most. fixed: members whose start is given, such as
    characters that are not of the cast. A member that is stuck goes first in another try.
    """
    given = dict(fixed or {})
    free = [k for k in range(len(lengths)) if k not in given]
    order = sorted(free, key=lambda k: (earliest[k], k))
    best: Schedule | None = None
    tried = set()
    while tuple(order) not in tried:
        tried.add(tuple(order))
        made = _in_order(order, conflicts_of, lengths, earliest, longest_wait, given)
        if best is None or len(made.stuck) < len(best.stuck):
            best = made
        if not made.stuck:
            break
        first = next(iter(made.stuck))
        order = [first, *(k for k in order if k != first)]
    return best


def _in_order(
    order: Sequence[int],
    conflicts_of: Pairs,
    lengths: Sequence[int],
    earliest: Sequence[int],
    longest_wait: int,
    given: Mapping[int, int],
) -> Schedule:
    starts, stuck = dict(given), {}
    for number, member in enumerate(order):
        counts = []
        for wait in range(longest_wait + 1):
            begin = earliest[member] + wait
            met = {k: _meetings(conflicts_of, lengths, member, begin, k, at) for k, at in starts.items()}
            # Those that come later stand at their starts for now; they can leave in time if there is no other way.
            later = sum(_meetings(conflicts_of, lengths, member, begin, k, None) for k in order[number + 1 :])
            counts.append((sum(met.values()), later, begin, max(met, key=met.get, default=None)))
            if counts[-1][:2] == (0, 0):
                break
        least = min(counts, key=lambda entry: entry[:3])
        starts[member] = least[2]
        if least[0]:
            stuck[member] = least[3]
    return Schedule(tuple(starts[k] for k in range(len(lengths))), stuck)


def _meetings(
    conflicts_of: Pairs, lengths: Sequence[int], a: int, begin_a: int, b: int, begin_b: int | None
) -> int:
    """Return the number of frames in which two members are in each other; the start of b is None where it stands at
    its start all the time."""
    flags = _flags(conflicts_of, a, b)
    last = max(begin_a + lengths[a], 0 if begin_b is None else begin_b + lengths[b])
    time = np.arange(last + 1)
    rows = np.clip(time - begin_a, 0, lengths[a] - 1)
    columns = np.zeros_like(time) if begin_b is None else np.clip(time - begin_b, 0, lengths[b] - 1)
    return int(flags[rows, columns].sum())


def pause(
    conflicts_of: Pairs, lengths: Sequence[int], starts: Sequence[int], member: int, earliest: int, last: int
) -> int | None:
    """Return the last frame of a member's take, up to ``last``, in which it can wait for the others instead of at its
    start: it sets off at ``earliest``, and goes on there when it would come by as scheduled. None where it cannot.
    """
    delay = starts[member] - earliest
    for frame in range(min(last, lengths[member] - 1), 0, -1):
        time = np.arange(earliest, starts[member] + frame + 1)
        rows = np.minimum(time - earliest, frame)
        if delay > 0 and all(
            not _flags(conflicts_of, member, other)[
                rows, np.clip(time - starts[other], 0, lengths[other] - 1)
            ].any()
            for other in range(len(lengths))
            if other != member
        ):
            return frame
    return None


def _flags(conflicts_of: Pairs, a: int, b: int) -> np.ndarray:
    return conflicts_of[a, b] if a < b else conflicts_of[b, a].T
