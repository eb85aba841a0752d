"""From a cast and its scene to takes that keep clear of each other. Without Blender.

Places are assigned first, then all takes are generated as one batch, each along a path around the places of the
others; then each member sets off as early as those before it allow (timing.py). Members that meet others whenever
they set off are generated again, around where they met. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...body.balls import Track
from ...methods.take import Take
from ...progress import Progress, SubProgress
from ..driver import Store, Toolbox
from ..refine_takes import refine_take
from . import gazes, idling, pausing, seating, seeing, together
from .cast_take import OVERLAP, CastTake, overlaps, track
from .role import CastWork, Role
from .seating import STANDING, Seated
from .timing import Pairs, Schedule, pairs, pause, schedule

RATE = 10
"""Frames per second at which takes are compared to be scheduled."""

LONGEST_WAIT = 30.0
"""Seconds that a member may wait for the others."""

ROUNDS = 3
"""How often members that meet others are generated again."""

ANOTHER = 500_009
"""Added to the seed of a member that is generated again."""


def run(
    work: CastWork,
    progress: Progress = lambda stage, share: None,
    tools: Toolbox | None = None,
    store: Store | None = None,
    on_take: Callable[[CastTake], None] = lambda take: None,
) -> list[CastTake]:
    """Return the cast's takes in the order of their seeds; see driver.run for the other arguments."""
    tools, found = tools or Toolbox(), []
    seeds = work.cast.seeds
    for count, seed in enumerate(seeds):
        part = SubProgress(progress, count / len(seeds), 1 / len(seeds))
        made = _remembered(
            store, seed, lambda seed=seed, part=part: _Direction(work, seed, tools, part).run()
        )
        found.append(made)
        on_take(made)
    return found


def _remembered(store: Store | None, seed: int, make: Callable[[], CastTake]) -> CastTake:
    """Return what is made for a seed, or was made in an earlier run."""
    known = store.load(f"cast-{seed}") if store else None
    if known is not None and known[0]:
        return known[0][0]
    made = make()
    if store and not made.failures:
        store.save(f"cast-{seed}", [made], [])
    return made


class _Direction:
    """One take of a cast in the making."""

    def __init__(self, work: CastWork, seed: int, tools: Toolbox, progress: Progress) -> None:
        self.work, self.seed, self.tools, self.progress = work, seed, tools, progress
        self.seeds = {k: work.cast.member_seed(seed, k) for k in range(len(work.roles))}
        self.failures: dict[int, str] = {}
        self.takes: dict[int, Take] = {}
        self.tracks: dict[int, Track] = {}

    def run(self) -> CastTake:
        """Return the cast's take."""
        self.progress("Finding places", 0.0)
        roles = gazes.facing(seating.apart(seating.with_starts(self.work.roles, self.seed)))
        self.cast = {k: found for k, found in enumerate(seating.seat(roles, self.work.others)) if found}
        reasons: dict[tuple, str] = {}  # the members of a table ask for the same chairs
        for k, role in enumerate(roles):
            if k not in self.cast:
                key = role.pieces, role.action
                reasons[key] = reasons.get(key) or _no_place(role)
                self._fail(k, reasons[key])
        self._generate(self.cast, SubProgress(self.progress, 0.05, 0.5))
        made = self._on_the_way(self._scheduled())
        waits = self._waits(made)
        takes = gazes.looking(self._filled(waits), self.work.roles, self.begun(waits))
        return self._finished(takes, waits)

    def _fail(self, number: int, reason: str) -> None:
        self.failures[number] = f"'{self.work.roles[number].member.name}': {reason}"

    def _generate(
        self, members: Mapping[int, Seated], progress: Progress, blocked: Mapping[int, Sequence] | None = None
    ) -> None:
        """Generate the takes of some members around the others; where there is no way around, through them."""
        rows = {}
        for k, seated in members.items():
            others = [other for number, other in self.cast.items() if number != k]
            taken = [(other.pelvis, STANDING) for other in self.work.others]
            taken += (blocked or {}).get(k, ())
            rows[k] = seating.around_others(seated, others, taken).steps
        alone = seeing.seeing(rows, self.tools.methods)
        batch = {k: row for k, row in rows.items() if k not in alone}
        reasons = self._make(batch, members, progress)
        for k in alone:
            reasons |= self._make({k: self._among(rows[k], k)}, members, progress)
        again = {k: members[k].steps for k in reasons}
        if again:
            reasons = self._make(again, members, progress)
        for k, reason in reasons.items():
            if k not in self.takes:
                self._fail(k, reason)

    def _make(
        self, rows: Mapping[int, together.Row], members: Mapping[int, Seated], progress: Progress
    ) -> dict[int, str]:
        """Generate and keep the takes of these steps; return, by member, why there is none."""
        made, reasons = together.generate(rows, self.seeds, self.tools.methods, progress)
        for k, take in made.items():
            self.takes[k] = take if members[k].pause is None else pausing.merged(take)
            self.tracks[k] = track(take.motion, self.work.roles[k].body, RATE)
        return reasons

    def _among(self, row: together.Row, number: int) -> together.Row:
        """Return the steps of a member with all bodies so far in the scene of the first one."""
        begin = self._earliest(number)
        members = [(self.tracks[k], self._earliest(k) - begin) for k in self.takes if k != number]
        return seeing.among(row, members + [(other.track, -begin) for other in self.work.others])

    def _scheduled(self) -> Schedule:
        """Return when the members set off; generate those again that meet others whenever they do."""
        progress = SubProgress(self.progress, 0.55, 0.2)
        known = {}
        for count in range(ROUNDS + 1):
            progress("Directing", count / (ROUNDS + 1))
            numbers, tracks = sorted(self.takes), self._tracks()
            known = pairs(tracks, known)
            made = self._schedule(known)
            if not made.stuck or count == ROUNDS:
                return made
            stuck = {numbers[k]: met(tracks, made, k, other) for k, other in made.stuck.items()}
            self.seeds |= {k: (self.seeds[k] + ANOTHER) % 2**31 for k in stuck}
            self._generate({k: self.cast[k] for k in stuck}, progress, stuck)
            redone = {numbers.index(k) for k in stuck}
            known = {pair: flags for pair, flags in known.items() if not redone & set(pair)}
        return made

    def _tracks(self) -> list[Track]:
        """Return the bodies of all members that have takes, and of those that are not of the cast."""
        return [self.tracks[k] for k in sorted(self.takes)] + [other.track for other in self.work.others]

    def _earliest(self, number: int) -> int:
        return round(self.work.roles[number].member.delay * RATE)

    def _schedule(self, known: Pairs) -> Schedule:
        numbers, others = sorted(self.takes), len(self.work.others)
        return schedule(
            known,
            [len(one) for one in self._tracks()],
            [*map(self._earliest, numbers), *[0] * others],
            round(LONGEST_WAIT * RATE),
            {len(numbers) + k: 0 for k in range(others)},
        )

    def _on_the_way(self, made: Schedule) -> Schedule:
        """Return a schedule in which members that wait for long do so on their way, where that helps."""
        numbers, tracks = sorted(self.takes), self._tracks()
        lengths = [len(one) for one in tracks]
        late = [
            k for k in numbers if made.starts[numbers.index(k)] - self._earliest(k) >= pausing.WORTH * RATE
        ]
        if not late or made.stuck or pausing.METHOD not in self.tools.methods:
            return made
        known, paused = pairs(tracks), {}
        for k in late:
            index, take = numbers.index(k), self.takes[k]
            end = take.motion.interaction_start or self._rested(k)
            frame = pause(
                known,
                lengths,
                made.starts,
                index,
                self._earliest(k),
                round(end / take.motion.fps * RATE) - RATE,
            )
            if frame is None or self.cast[k].steps[0][1].via:
                continue
            seconds = (made.starts[index] - self._earliest(k)) / RATE
            where = pausing.at(take, round(frame * take.motion.fps / RATE), seconds)
            if where is not None:
                paused[k] = replace(self.cast[k], pause=where)
        before = dict(self.cast), dict(self.takes), dict(self.tracks), dict(self.failures)
        self.cast |= paused
        self._generate(paused, SubProgress(self.progress, 0.7, 0.05))
        again = self._schedule(pairs(self._tracks()))
        if paused and not again.stuck and sum(again.starts) < sum(made.starts):
            return again
        self.cast, self.takes, self.tracks, self.failures = before
        return made

    def _rested(self, number: int) -> int:
        """Return the frame of a member's own take in which it has come to rest."""
        motion = self.takes[number].motion
        return round((motion.seconds - self.work.roles[number].member.job.hold) * motion.fps)

    def _waits(self, made: Schedule) -> dict[int, float]:
        return {k: made.starts[index] / RATE for index, k in enumerate(sorted(self.takes))}

    def begun(self, waits: Mapping[int, float]) -> dict[int, int]:
        """Return the frame in which each member has come to rest."""
        found = {}
        for k, take in self.takes.items():
            found[k] = round(waits[k] * take.motion.fps) + self._rested(k)
        return found

    def _filled(self, waits: Mapping[int, float]) -> dict[int, Take]:
        """Return the takes with the time before and after them, all equally long."""
        views = {k: self.cast[k].steps[0][1] for k in self.takes}
        progress = SubProgress(self.progress, 0.75, 0.15, "Waiting")
        takes = idling.waiting(self.takes, waits, views, self.seeds, self.tools.methods, progress)
        longest = max((len(take.motion) for take in takes.values()), default=0)
        return {k: idling.lengthened(take, longest) for k, take in takes.items()}

    def _finished(self, takes: dict[int, Take], waits: Mapping[int, float]) -> CastTake:
        """Return the takes refined where wanted, with what remains of overlaps."""
        surroundings = self.work.surroundings
        for count, k in enumerate(takes if surroundings is not None else ()):
            part = SubProgress(self.progress, 0.9 + 0.1 * count / len(takes), 0.1 / len(takes))
            takes[k], failure = refine_take(
                takes[k], surroundings, self.work.roles[k].body, self.tools.refine, part
            )
            if failure is not None:
                self._fail(k, failure.message)
        bodies = {k: self.work.roles[k].body for k in takes}
        depths = overlaps({k: take.motion for k, take in takes.items()}, bodies)
        deepest, met = 0.0, np.zeros(max((len(d) for d in depths.values()), default=1), dtype=bool)
        for (a, b), depth in depths.items():
            deepest = max(deepest, float(depth.max(initial=0.0)))
            met[: len(depth)] |= depth > OVERLAP
            if (depth > OVERLAP).any():
                for one, two in ((a, b), (b, a)):
                    name = self.work.roles[two].member.name
                    remark = f"The body is up to {100 * depth.max():.0f} cm in that of '{name}'."
                    takes[one] = replace(takes[one], remarks=(*takes[one].remarks, remark))
        for k, take in takes.items():
            seed = self.work.cast.member_seed(self.seed, k)
            takes[k] = replace(take, seed=seed)
        self.progress("Done", 1.0)
        targets = {k: self.cast[k].role.pieces[self.cast[k].option] for k in takes}
        return CastTake(
            self.seed, takes, targets, dict(waits), dict(self.failures), deepest, float(met.mean())
        )


def met(tracks: Sequence[Track], made: Schedule, member: int, other: int) -> list:
    """Return the ground on which a member meets another one, to be walked around."""
    a, b = tracks[member], tracks[other]
    last = max(made.starts[member] + len(a), made.starts[other] + len(b))
    time = np.arange(last)
    rows = np.clip(time - made.starts[member], 0, len(a) - 1)
    columns = np.clip(time - made.starts[other], 0, len(b) - 1)
    middle_a, middle_b = a.bounds()[0][rows], b.bounds()[0][columns]
    nearest = int(np.linalg.norm((middle_a - middle_b)[:, [0, 2]], axis=-1).argmin())
    return [(middle_b[nearest], STANDING)]


def _no_place(role: Role) -> str:
    """Return why there is no place left for a role: others have all of them, or things are in the way."""
    reason = seating.obstruction(role)
    if reason:
        return reason
    verb = role.action
    if len(role.pieces) > 1:
        return (
            f"there is no free place to {verb} left on {_listed(role.pieces)}; add furniture or leave it out."
        )
    return f"there is no free place to {verb} left on '{role.pieces[0]}'; name another target."


def _listed(names: Sequence[str]) -> str:
    shown = [f"'{name}'" for name in names[:4]]
    return ", ".join(shown) + (", ..." if len(names) > 4 else "")
