"""Long sits from Rocketbox's short ones: sitting down, seated idles, standing up, chained where they rest.

Each of these clips begins or ends in one of four seated rest poses, of a woman and a man on a chair and at a table.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..mocap.augment import relocked
from ..mocap.clip_files import Clip
from .stitch import join, pose_features

PERSONS = ("rb_f", "rb_m")
SEATS = ("chair", "table")
EDGE = 6  # frames at the end of a clip and at the beginning of the next among which the join is chosen
ALIKE = 0.35  # largest distance of pose features at a join
STANDS_UP = 0.6  # share of the sits that end in standing up where there is such a clip
MOST_IDLES = 2


def long_sits(clips: list[Clip], each: int, rng: np.random.Generator) -> list[Clip]:
    """``each`` chained sits of every captured sitting down in the set; the same names are different draws."""
    chained = []
    for person in PERSONS:
        for seat in SEATS:
            downs = _named(clips, f"{person}_sit_down_{seat}")
            idles = _named(clips, f"{person}_sit_{seat}")
            ups = _named(clips, f"{person}_sit_stand_up_{seat}")
            for down in downs:
                chained += [_chained(down, idles, ups, rng) for _ in range(each)]
    return [clip for clip in chained if clip is not None]


def _named(clips: list[Clip], start: str) -> list[Clip]:
    return [clip for clip in clips if clip.name.startswith(start)]


def _chained(down: Clip, idles: list[Clip], ups: list[Clip], rng: np.random.Generator) -> Clip | None:
    """One sit: down, up to two idles and perhaps up; None where no idle goes on from it."""
    made = down
    for _ in range(int(rng.integers(1, MOST_IDLES + 1))):
        longer = _continued(made, idles, rng)
        made = longer or made
    if made is down:
        return None
    if ups and rng.random() < STANDS_UP:
        made = _continued(made, ups, rng) or made
    return replace(relocked(made), name=down.name)


def _continued(before: Clip, choices: list[Clip], rng: np.random.Generator) -> Clip | None:
    """``before`` and one of the clips that go on from its last frames, or None."""
    ends = pose_features(before.root, before.rotations)[-EDGE:]
    for k in rng.permutation(len(choices)):
        after = choices[k]
        begins = pose_features(after.root, after.rotations)[:EDGE]
        apart = np.linalg.norm(ends[:, None] - begins[None], axis=-1)
        last, first = np.unravel_index(apart.argmin(), apart.shape)
        if apart[last, first] < ALIKE:
            return join(before.cut(0, len(before) - EDGE + int(last) + 1), after.cut(int(first), len(after)))
    return None
