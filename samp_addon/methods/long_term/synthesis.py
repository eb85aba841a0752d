"""One take: a body at each stop, a window between each two, joined (sections 3.2 to 3.4). Network frame, metres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ... import skeleton
from ...body import betas as shapes
from ...body import hand_poses, proportions
from ...frames import ground_lengths
from ...motion import Motion
from ...refine.feet.foot import FEET
from ...vocabulary import SEATED
from . import joining, networks, resting, variety, way
from .figure import Figure
from .networks import Crossing, Networks
from .planning import Leg
from .sub_goals import bodies
from .sub_goals.places import Place
from .surfaces import Surfaces
from .variety import Gait

CYCLE = 1.15
"""Metres of way in two steps, as in models/long_term/gait.py."""
AROUND = 2.0
"""Metres around both ends of a window from which its cloud is taken."""
RESTING_PACE = 0.85
"""Of the usual pace in windows onto and off furniture, whose pelvis is hasty otherwise."""
HELD = 60
"""Frames of the windows in which a body stays where it is, at most."""
LEAST_HELD = 3
LEARNT = {
    "male": 1.0, "female": 0.4, "tall": 0.5, "short": 0.2, "heavy": 0.3, "thin": 0.6, "muscular": 0.4, "elder": 0.5,
}  # fmt: skip
"""Largest values of the shapes among the bodies that the networks have learnt from."""


@dataclass
class Made:
    """A take in the making. figures, frames: of the places that the artist chose, with the frames in which they are
    reached; the parts of the take follow each other."""

    parts: list[joining.Part] = field(default_factory=list)
    floors: list[np.ndarray] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)

    @property
    def length(self) -> int:
        """Frames so far, less the first one."""
        return sum(len(part.motion) - 1 for part in self.parts)

    def add(self, motion: Motion, begin: str, end: str, floor: np.ndarray) -> None:
        """Append a window. floor: heights (T, 3) under its pelvis and its feet."""
        self.parts.append(joining.Part(motion, begin, end))
        self.floors.append(floor[1:])


@dataclass(frozen=True)
class Synthesis:
    """What all takes of a step share.

    scale: standard deviation of all noise. speed: factor on the usual pace. pause, hold: seconds at each place between
    and at the last one.
    """

    networks: Networks
    surfaces: Surfaces
    betas: np.ndarray
    scale: float
    speed: float
    pause: float
    hold: float

    def take(
        self, start: Place, legs: Sequence[Leg], rng: np.random.Generator, figure: Figure | None,
        progress: Callable[[float], None],
    ) -> tuple[Motion, Made]:  # fmt: skip
        """Return the motion from a start along its legs. figure: with which it begins, or None to draw one."""
        made = Made()
        figure = figure or start.body
        if figure is None:
            figure = bodies.choose(self.networks, self.surfaces, start, self.betas, rng, self.scale)
        made.figures.append(figure)
        made.frames.append(0)
        place, count = start, sum(len(leg.stops) for leg in legs)
        for number, leg in enumerate(legs):
            if number:
                self._hold(made, figure, place, variety.pause(self.pause, rng, self.scale), rng)
            gait = variety.gait(rng, self.scale)
            for stop, path in zip(leg.stops, leg.paths, strict=True):
                progress(len(made.parts) / max(count + len(legs), 1))
                figure = self._step(made, figure, place, stop, path, gait, rng)
                place = stop
            made.figures.append(figure)
            made.frames.append(made.length)
        self._hold(made, figure, place, self.hold, rng)
        motion, _ = joining.joined(made.parts)
        floor = np.concatenate([made.floors[0][:1], *made.floors])
        return joining.finished(motion, floor[:, 0], floor[:, 1:]), made

    def _step(
        self, made: Made, figure: Figure, place: Place, stop: Place, path: np.ndarray, gait: Gait,
        rng: np.random.Generator,
    ) -> Figure:  # fmt: skip
        """Add the window to a stop; return the body there."""
        rests, phase = bool({place.action, stop.action} & set(SEATED)), None
        if not stop.fixed:
            strides = ground_lengths(path)[-1] / (CYCLE * gait.stride)
            phase = float(np.arctan2(*networks.phase(figure)[::-1])) + 2 * np.pi * float(strides)
        target = stop.body
        if target is None:
            target = bodies.choose(self.networks, self.surfaces, stop, self.betas, rng, self.scale, phase)
        line = np.concatenate([figure.root[None], path[1:-1], target.root[None]])
        pace = (
            RESTING_PACE * min(gait.pace, 1.0) if rests else gait.pace
        )  # a fast gait does not make sitting down faster
        crossing = Crossing(
            figure, target, way.resampled(line), (not place.fixed, not stop.fixed), pace * self.speed,
            networks.noises(rng, self.scale), (place.action == "sit", stop.action == "sit"),
        )  # fmt: skip
        motion = self.networks.cross(crossing, self._cloud(figure, target, rng))
        for change in (resting.planted, resting.paced, resting.hastened):
            motion = change(motion, place.action, stop.action)
        made.add(motion, place.action, stop.action, self.floors(motion, figure.level, target.level))
        return target

    def floors(self, motion: Motion, first: float, last: float) -> np.ndarray:
        """Return the heights (T, 3) of the floor under the pelvis and the feet of a window."""
        joints = motion.forward_kinematics()[0]
        under = [motion.root, *(joints[:, foot.ball] for foot in FEET)]
        return np.stack([self.surfaces.floors(places, first, last) for places in under], axis=-1)

    def _hold(
        self, made: Made, figure: Figure, place: Place, seconds: float, rng: np.random.Generator
    ) -> None:
        """Add windows in which a body stays where it is."""
        left = round(seconds * 30)
        still = way.resampled(np.array([figure.root, figure.root]))
        while left >= LEAST_HELD:
            frames = min(left, HELD)
            crossing = Crossing(figure, figure, still, (False, False), 1.0, networks.noises(rng, self.scale))
            motion = self.networks.cross(crossing, self._cloud(figure, figure, rng), frames + 1)
            motion = resting.stilled(motion) if is_resting(place) else motion
            made.add(motion, place.action, place.action, np.full((len(motion), 3), figure.level))
            left -= frames

    def _cloud(self, start: Figure, end: Figure, rng: np.random.Generator) -> np.ndarray:
        both = np.array([start.root, end.root])
        return self.surfaces.cloud(both, AROUND, start.level, int(rng.integers(2**31)))


def last_figure(motion: Motion, betas: np.ndarray, level: float) -> Figure:
    """Return the body in which a take ends, in the proportions of betas (10,)."""
    last = motion.pose_slice(slice(-1, None))
    if motion.contacts is not None:
        last = replace(last, contacts=motion.contacts[-1:])
    motion = proportions.adapt(last, shapes.body_of(betas).joints)
    rotations = motion.rotations[-1:]
    return Figure(
        motion.root[-1],
        rotations[0, : skeleton.BODY_COUNT],
        hand_poses.read_hands(rotations)[0],
        betas,
        level,
    )


def known_betas(betas: np.ndarray | None) -> np.ndarray:
    """Return the betas (10,) nearest to some that the networks have learnt from; None for the default human."""
    return np.zeros(shapes.COUNT) if betas is None else np.clip(betas, 0.0, shapes.from_named(LEARNT))


def is_resting(place: Place) -> bool:
    """Return whether a body sits or lies at a place."""
    return place.action in SEATED
