"""What people do on a piece of furniture: sits and lies in its own frame, from captured clips.

``Uses`` is the seam: whatever gives a list of ``Use`` for an item can take the place of ``Composed``, such as sits and
lies that were fitted to the piece.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from ....samp_addon import rotation
from ....samp_addon.motion import Goal
from ....samp_addon.scene import geometry
from ....samp_addon.scene.seats import seats
from ...composition import recline
from ...composition.checks import fault
from ...composition.lies import LieComposer
from ...composition.sequence import Sequence
from ...composition.sits import Furnishing, collides, lifted, placement, untouched
from ...mocap.augment import relocked
from ...mocap.clip_files import Clip
from ...mocap.events import SitEvent, headings, label_runs, sit_events, turned
from ..layout.stock import Item
from .bank import LABELS

BEFORE, AFTER = 50, 20  # frames kept before sitting down and after standing up
SAME_PLACE = 0.12  # metres between pelvises that rest in the same place
REST = 150  # frames of the hold with which a reversed rise begins
MOST_LIFT = 0.12  # metres by which a captured sit is raised or lowered
GOALS = 3  # places on a piece
TRIES = {"whole": 7, "hold": 3, "up": 4}  # captured pieces tried for each place
LIES, LIE_TRIES = 4, 9
FORWARD = (0.0, 0.08, 0.16)  # metres towards the edge by which deep seats are sat on, in this order
WORTH = 0.6  # of the best place's score


@dataclass(frozen=True)
class Use:
    """A stretch of motion on a piece of furniture, in the piece's frame, metres.

    action: "sit" or "lie". place: number of the place on the piece; uses of one place may follow on each other.
    root (T, 3), rotations (T, 22, 4), labels (T,) indices into bank.LABELS, feet (T, 2), hands (T, 2), source (T,)
    bank frames or -1. down, seated, seat_end, up_end: first frame of sitting down, first and last seated, last of
    standing up; down is -1 where it begins seated, up_end is -1 where it ends seated. fitted: whether an optimiser
    fitted it to the piece.
    """

    action: str
    place: int
    root: np.ndarray
    rotations: np.ndarray
    labels: np.ndarray
    feet: np.ndarray
    hands: np.ndarray
    source: np.ndarray
    down: int
    seated: int
    seat_end: int
    up_end: int
    fitted: bool = False


class Uses(Protocol):
    """Where uses come from."""

    def of(self, item: Item) -> list[Use]:
        """All uses of an item, the same each time."""


def cached(path: Path, make: Callable[[], list[Use]]) -> list[Use]:
    """Return the uses kept in a file of the cache; where there is none, make and keep them.

    Workers may make the same file at once: each writes a part of its own, and the last one stays.
    """
    if path.exists():
        return pickle.loads(path.read_bytes())
    uses = make()
    part = path.with_suffix(f".{np.random.default_rng().integers(1 << 30)}")
    part.write_bytes(pickle.dumps(uses))
    part.replace(path)
    return uses


@dataclass(frozen=True)
class _Sitting:
    """A captured stretch. offset: bank frame of the clip's first frame; the others as in Use, in the clip's frames."""

    clip: Clip
    offset: int
    down: int
    seated: int
    seat_end: int
    up_end: int
    pelvis: np.ndarray
    yaw: float


class Composed:
    """Uses by today's composer: captured sits carried to the height of a seat, lies composed of sits and reclines."""

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
        """See Uses; kept in a file for each item."""
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


def reversed_rise(use: Use) -> Use | None:
    """Return the way down of a use played backwards, as a rise that begins at rest; None without a way down.

    It begins with up to REST frames of the hold and ends standing, AFTER frames or fewer after the feet carry again.
    """
    if use.down < 0:
        return None
    first = max(use.down - AFTER, 0)
    stop = min(use.seated + REST, use.seat_end + 1)
    part = slice(first, stop)
    back = lambda values: values[part][::-1].copy()
    labels = back(use.labels)
    renamed = {
        LABELS.index(a): LABELS.index(b) for a, b in (("sit_down", "stand_up"), ("lie_down", "get_up"))
    }
    labels = np.array([renamed.get(int(label), int(label)) for label in labels], np.uint8)
    count = stop - first
    return replace(
        use, root=back(use.root), rotations=back(use.rotations), labels=labels, feet=back(use.feet),
        hands=back(use.hands), source=back(use.source), down=-1, seated=0, seat_end=count - 1 - (use.seated - first),
        up_end=count - 1 - (use.down - first),
    )  # fmt: skip


def place_of(uses: list[Use], made: Use) -> int:
    """Number of the place of a use on its piece: that of an earlier use close by, or a new one."""
    pelvis = lambda use: np.median(use.root[use.seated : use.seat_end + 1], axis=0)
    for use in uses:
        if use.action == made.action and np.linalg.norm(pelvis(use) - pelvis(made)) < SAME_PLACE:
            return use.place
    return max((use.place for use in uses), default=-1) + 1


def with_rises(uses: list[Use]) -> list[Use]:
    """Return the uses, and a reversed rise for each that ends at rest."""
    return [*uses, *(rise for use in uses if use.up_end < 0 and (rise := reversed_rise(use)) is not None)]


def of_sequence(made: Sequence, place: int, source: np.ndarray | None = None, fitted: bool = False) -> Use:
    """The use of a training sequence that sits or lies; source: bank frames (T,) of it, None where not known."""
    labels, count = made.labels, len(made)
    lies = bool((labels == "lie").any())
    going, resting, leaving = (
        ("lie_down", "lie", ("get_up", "stand_up")) if lies else ("sit_down", "sit", ("stand_up",))
    )
    down, still = int(np.argmax(labels == going)), np.flatnonzero(labels == resting)
    ups = np.flatnonzero(np.isin(labels, leaving) & (np.arange(count) > still[-1]))
    start, stop = max(0, down - BEFORE), min(int(ups[-1]) + AFTER, count) if len(ups) else int(still[-1]) + 1
    clip = Clip("", made.root, made.rotations, labels, made.feet, made.bad).cut(start, stop)
    frames = (
        down - start,
        int(still[0]) - start,
        int(still[-1]) - start,
        int(ups[-1]) - start if len(ups) else -1,
    )
    use = _in_frame(clip, made.placement, "lie" if lies else "sit", place, frames, None)
    part = slice(start, stop)
    return replace(
        use,
        source=use.source if source is None else source[part].astype(np.int32),
        hands=use.hands if made.hands is None else made.hands[part].astype(np.float32),
        fitted=fitted,
    )


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
    """Carry a captured stretch to a seat; return the use, None where it does not fit, and the next ``skip``.

    skip: number of leading entries of FORWARD that failed for an earlier stretch at this seat.
    """
    start = max(0, s.down - BEFORE) if s.down >= 0 else s.seated
    # What lies before belongs to the sit before it.
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
    return _in_frame(clip, where, "sit", place, frames, s.offset + start), number


def _in_frame(
    clip: Clip, where: tuple[float, float, float], action: str, place: int, frames: tuple[int, int, int, int],
    first: int | None,
) -> Use:  # fmt: skip
    """The clip seen from a piece that stands at ``where`` (x, z, yaw)."""
    root, rotations = turned(
        clip.root - np.array([where[0], 0.0, where[1]]), clip.rotations, -where[2], np.zeros(3)
    )
    index = {label: k for k, label in enumerate(LABELS)}
    count = len(clip)
    source = np.full(count, -1) if first is None else first + np.arange(count)
    return Use(
        action, place, root, rotation.continuous(rotations), np.array([index[x] for x in clip.labels], np.uint8),
        clip.feet.astype(np.float32), np.zeros((count, 2), np.float32), source.astype(np.int32), *frames,
    )  # fmt: skip
