"""Composed uses: captured sits adapted to the height of a seat, lies composed of sits and reclines."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ....samp_addon.motion import Goal
from ....samp_addon.scene import geometry
from ....samp_addon.scene.seats import seats
from ...composition import recline
from ...composition.checks import fault
from ...composition.lies import LieComposer
from ...composition.sits import Furnishing, collides, lifted, placement, untouched
from ...mocap.augment import relocked
from ...mocap.clip_files import Clip
from ...mocap.events import SitEvent, headings, label_runs, sit_events
from ..layout.stock import Item
from .use import AFTER, BEFORE, Use, cached, in_frame, of_sequence

MOST_LIFT = 0.12  # metres by which a captured sit may be raised or lowered
GOALS = 3  # places on a piece
TRIES = {"whole": 7, "hold": 3, "up": 4}  # captured excerpts to try for each place
LIES, LIE_TRIES = 4, 9
FORWARD = (0.0, 0.08, 0.16)  # offsets (m) towards the edge, tried in this order on deep seats
WORTH = 0.6  # least score of a place, relative to the best one's


@dataclass(frozen=True)
class _Sitting:
    """A captured excerpt. offset: bank frame of the clip's first frame; other frames as in Use, in the clip."""

    clip: Clip
    offset: int
    down: int
    seated: int
    seat_end: int
    up_end: int
    pelvis: np.ndarray
    yaw: float


class Composed:
    """Uses composed from the clips of a bank."""

    def __init__(self, clips: list[Clip], cache: Path) -> None:
        offsets = np.concatenate([[0], np.cumsum([len(clip) for clip in clips])])
        self.cache = Path(cache)
        self.cache.mkdir(parents=True, exist_ok=True)
        self.sittings: dict[str, list[_Sitting]] = {"whole": [], "up": [], "hold": []}
        self.events: list[SitEvent] = []
        for clip, offset in zip(clips, offsets[:-1], strict=True):
            events = sit_events(clip)
            self.events += events
            for kind, sitting in _sittings(clip, int(offset), events):
                self.sittings[kind].append(sitting)
        self.reclines = recline.reclines(clips)

    def of(self, item: Item) -> list[Use]:
        """Return all uses of an item, cached in a file; see Uses."""
        return cached(self.cache / f"{item.name}.pkl", lambda: self._made(item))

    def _made(self, item: Item) -> list[Use]:
        seed = int.from_bytes(hashlib.sha256(item.name.encode()).digest()[:4], "little")
        rng = np.random.default_rng(seed)
        surface, _ = geometry.sample_surface(item.triangles, 5000, seed=0)
        support = seats.support_map(item.triangles, floor_height=0.0)
        found = seats.seats_on_map(support, "sit", 12)
        worth = [s.goal for s in found if s.score >= WORTH * found[0].score][:GOALS]
        piece = Furnishing(0, surface, worth)
        uses: list[Use] = []
        for place, goal in enumerate(worth):
            for kind, tries in TRIES.items():
                uses += self._sits(kind, piece, goal, place, tries, rng)
        lying = [s.goal for s in seats.seats_on_map(support, "lie", 8)]
        if lying:
            uses += self._lies(Furnishing(0, surface, lying), len(worth), seed)
        return uses

    def _sits(
        self, kind: str, piece: Furnishing, goal: Goal, place: int, tries: int, rng: np.random.Generator
    ) -> list[Use]:
        fits = [s for s in self.sittings[kind] if abs(s.pelvis[1] - goal.position[1]) < MOST_LIFT]
        made, skip = [], 0
        for k in rng.permutation(len(fits))[:tries]:
            use, skip = _sat(fits[k], piece, goal, place, skip)
            made += [use] if use is not None else []
        return made

    def _lies(self, piece: Furnishing, place: int, seed: int) -> list[Use]:
        composer = LieComposer([piece], self.events, self.reclines, lambda clip, frames: (clip, frames), seed)
        if not composer.places:
            return []
        uses: list[Use] = []
        for _ in range(LIE_TRIES):
            made = composer.compose()
            if made is not None and len(uses) < LIES:
                uses.append(of_sequence(made, place + len(uses)))
        return uses


def _sittings(clip: Clip, offset: int, events: list[SitEvent]) -> list[tuple[str, _Sitting]]:
    out = []
    for e in events:
        up = e.up_end if e.up_end > e.seat_end else -1
        out.append(("whole", _Sitting(clip, offset, e.down, e.seated, e.seat_end, up, e.pelvis, e.yaw)))
        if up > 0:
            out.append(("up", _Sitting(clip, offset, -1, e.seated, e.seat_end, up, e.pelvis, e.yaw)))
    runs = label_runs(clip.labels)
    for k, (label, first, stop) in enumerate(runs):
        if label != "sit" or any(e.seated == first for e in events) or clip.bad[first:stop].any():
            continue
        following = runs[k + 1] if k + 1 < len(runs) else ("", stop, stop)
        if following[0] == "stand_up" and stop - first > 4:
            out.append(("up", _sitting(clip, offset, first, stop - 1, following[2] - 1)))
        elif stop - first >= 90 and stop - first > 0.95 * len(clip):
            out.append(("hold", _sitting(clip, offset, first, stop - 1, -1)))
    return out


def _sitting(clip: Clip, offset: int, seated: int, seat_end: int, up_end: int) -> _Sitting:
    part = slice(seated, seat_end + 1)
    yaw = headings(clip.root[part], clip.rotations[part])
    pelvis = np.median(clip.root[part], axis=0)
    mean = float(np.arctan2(np.sin(yaw).mean(), np.cos(yaw).mean()))
    return _Sitting(clip, offset, -1, seated, seat_end, up_end, pelvis, mean)


def _sat(s: _Sitting, piece: Furnishing, goal: Goal, place: int, skip: int) -> tuple[Use | None, int]:
    """Adapt a captured excerpt to a seat; return the use, None where it does not fit, and the next ``skip``.

    skip: number of leading entries of FORWARD that failed for an earlier excerpt at this seat.
    """
    start = max(0, s.down - BEFORE) if s.down >= 0 else s.seated
    # Frames up to the last seated one before it belong to the previous sit.
    earlier = np.flatnonzero(np.isin(s.clip.labels[start : max(s.down, start)], ("sit", "stand_up")))
    start += int(earlier[-1]) + 1 if len(earlier) else 0
    stop = min(s.up_end + AFTER, len(s.clip)) if s.up_end >= 0 else s.seat_end + 1
    later = np.flatnonzero(np.isin(s.clip.labels[s.up_end : stop], ("sit_down",))) if s.up_end >= 0 else []
    stop = s.up_end + int(later[0]) if len(later) else stop
    clip = s.clip.cut(start, stop)
    lift = float(goal.position[1] - s.pelvis[1])
    if s.down < 0 and s.up_end < 0:
        clip = replace(clip, root=clip.root + [0.0, lift, 0.0])
    else:
        clip = lifted(clip, s.pelvis[1], lift)
    clip = relocked(clip)
    if fault(clip) is not None:
        return None, skip
    seat = slice(s.seated - start, s.seat_end - start + 1)
    pelvis = np.median(clip.root[seat], axis=0)
    near = np.zeros(len(clip), bool)
    near[max(s.down - start, 0) : (s.up_end - start + 1) if s.up_end >= 0 else None] = True
    for number in range(skip, len(FORWARD)):
        nearer = replace(goal, position=goal.position + FORWARD[number] * goal.direction)
        where = placement(nearer, pelvis, s.yaw)
        if untouched(pelvis, piece, where):
            return None, skip
        if collides(clip, piece, where, near) is None:
            break
    else:
        return None, skip
    shift = lambda frame: frame - start if frame >= 0 else -1
    frames = (shift(s.down), shift(s.seated), shift(s.seat_end), shift(s.up_end))
    return in_frame(clip, where, "sit", place, frames, s.offset + start), number
