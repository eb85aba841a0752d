"""Long sits composed from Rocketbox's short clips: sitting down, seated idles and standing up, joined at rest poses.

Each clip starts or ends in one of four seated rest poses, of a woman and a man on a chair and at a table.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..mocap.augment import relocked
from ..mocap.clip_files import Clip
from .stitch import join, pose_features

PERSONS = ("rb_f", "rb_m")
SEATS = ("chair", "table")
EDGE = 6  # frames at the end of a clip and the start of the next from which the join is chosen
MAX_DISTANCE = 0.35  # largest distance of pose features at a join
STAND_UP_SHARE = 0.6  # share of sits that end in standing up, if there is such a clip
MAX_IDLES = 2


def long_sits(clips: list[Clip], each: int, rng: np.random.Generator) -> list[Clip]:
    """Compose ``each`` sits from every captured sitting down; sits of the same name differ by the random choice."""
    composed = []
    for person in PERSONS:
        for seat in SEATS:
            downs = _named(clips, f"{person}_sit_down_{seat}")
            idles = _named(clips, f"{person}_sit_{seat}")
            ups = _named(clips, f"{person}_sit_stand_up_{seat}")
            for down in downs:
                composed += [_compose(down, idles, ups, rng) for _ in range(each)]
    return [clip for clip in composed if clip is not None]


def _named(clips: list[Clip], start: str) -> list[Clip]:
    return [clip for clip in clips if clip.name.startswith(start)]


def _compose(down: Clip, idles: list[Clip], ups: list[Clip], rng: np.random.Generator) -> Clip | None:
    """Return a sit of down, up to MAX_IDLES idles and possibly up, or None if no idle continues ``down``."""
    made = down
    for _ in range(int(rng.integers(1, MAX_IDLES + 1))):
        longer = _continue(made, idles, rng)
        made = longer or made
    if made is down:
        return None
    if ups and rng.random() < STAND_UP_SHARE:
        made = _continue(made, ups, rng) or made
    return replace(relocked(made), name=down.name)


def _continue(before: Clip, choices: list[Clip], rng: np.random.Generator) -> Clip | None:
    """Return ``before`` joined with one of the clips that continue its last frames, or None."""
    ends = pose_features(before.root, before.rotations)[-EDGE:]
    for k in rng.permutation(len(choices)):
        after = choices[k]
        begins = pose_features(after.root, after.rotations)[:EDGE]
        apart = np.linalg.norm(ends[:, None] - begins[None], axis=-1)
        last, first = np.unravel_index(apart.argmin(), apart.shape)
        if apart[last, first] < MAX_DISTANCE:
            return join(before.cut(0, len(before) - EDGE + int(last) + 1), after.cut(int(first), len(after)))
    return None
