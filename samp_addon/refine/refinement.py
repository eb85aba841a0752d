"""Refinement of any take against its scene: contact, penetration, foot slide, smoothness (Long-term motion, section
3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .. import rotation, skeleton
from ..body import human
from ..body.human import Human
from ..easing import smoothstep
from ..errors import SampError
from ..evaluation import metrics
from ..evaluation.obstacles import Obstacles, shared
from ..motion import Goal, Motion
from ..progress import Progress
from ..scene.distance import solids
from ..scene.geometry import extent
from .feet.foot_lock import lock_to_plans
from .feet.plan import FootPlan, lowest_ground, plan_feet
from .field import Field
from .hands import palm, reaching
from .hands.palm import HandContact
from .high_seats import knee_rises, knees_raised
from .hovering import settle

if TYPE_CHECKING:
    from .thin_things import ThinThings

SMOOTHING = 4.0  # frames at 30 fps: sigma of the Gaussian over time, per unit of the weight of smoothness
WINDOW, OVERLAP = 8.0, 1.0  # seconds
REACH = 1.0  # metres around the character within which there has to be something
OUTSIDE_SAMPLES = 500  # vertices that decide which side of a surface is outside
RESTING_SECONDS = 1.0  # at the end of a take that rests on its goal
NO_FLOOR = -1e3  # height of a floor that is out of the way
LAST_SETTLING = 0.04  # seconds, sigma; what still hovers at the end does so by little
LOOKED_AT = 5  # frames between two in which thin things are looked for in the result
UNSOLVED = 0.02  # metres of remaining depth that are worth a note


@dataclass(frozen=True)
class Settings:
    """Weights of the energies in the two stages (appendix 2).

    foot, collision, contact, smooth: of the feet's locations, which the first stage leaves out, and of equations 5 to
    7. close: of closeness to the input. limits: of the joint limits. thin: of thin things that pass through the body
    (thin_things.py). goal: of the pelvis on its goal. hand: of hands on what they are on. strength: share of the change
    that is kept, 0 to 1.
    """

    foot: float = 1.0
    collision: float = 1.0
    contact: float = 1.0
    smooth: float = 0.25
    close: float = 1.0
    limits: float = 1.0
    thin: float = 1.0
    goal: float = 1.0
    hand: float = 1.0
    strength: float = 1.0


@dataclass(frozen=True)
class Surroundings:
    """The scene that a take is refined against; network frame, metres.

    triangles: (F, 3, 3). give: (F,) by which the triangle's object yields under a body (its cushion depth). floor:
    height below which all is solid, or None where the triangles include all floors.
    """

    triangles: np.ndarray
    give: np.ndarray
    floor: float | None = None

    @cached_property
    def obstacles(self) -> Obstacles:
        """Return the obstacles for the measures; cached, because all takes in a scene share them."""
        return shared(self.triangles)


@dataclass(frozen=True)
class Refined:
    """A refined take.

    before, after: measures of the input and of the result (evaluation.metrics.measure). unsolved: largest remaining
    depth of the body in the scene, metres; 0 where it is free. notes: sentences for the artist.
    """

    motion: Motion
    before: dict
    after: dict
    unsolved: float = 0.0
    notes: tuple[str, ...] = field(default_factory=tuple)


def refine(
    motion: Motion,
    surroundings: Surroundings,
    goal: Goal | None = None,
    body: Human | None = None,
    settings: Settings | None = None,
    progress: Progress = lambda stage, share: None,
    measured: bool = True,
    hands: Sequence[HandContact] = (),
) -> Refined:
    """Refine a motion against its surroundings.

    body: the default human if omitted. progress: called with the stage and the share done; an exception that it
    raises stops the work. measured: whether before and after are filled in. hands: that are on something and stay
    there. Raises SampError for a motion that is not
    finite, and where no scene is near.
    """
    settings, body = settings or Settings(), body or human.load()
    _require_finite(motion)
    progress("Looking at the scene", 0.0)
    scene = _field(motion, surroundings, body)
    refined = smoothed(motion, settings.smooth)
    if settings.contact > 0:
        refined = settle(refined, scene, body)
    thin = _thin_things(refined, surroundings, body, scene, goal)
    if thin is not None and settings.thin > 0:
        refined = knees_raised(refined, knee_rises(refined, thin))
    feet = None
    for stage in (0, 1):
        feet = plan_feet(refined, scene, feet)
        refined = _optimise(refined, scene, body, settings, goal, feet, stage, progress, thin, hands)
    progress("Feet", 0.9)
    if settings.foot > 0:
        refined = lock_to_plans(refined, feet, scene)
    if settings.contact > 0:
        refined = settle(refined, scene, body, LAST_SETTLING)
    if settings.hand > 0:
        refined = reaching.kept(refined, hands)
    if settings.strength < 1:
        refined = blended(motion, refined, settings.strength)
    progress("Measuring", 0.95)
    return _result(motion, refined, surroundings, scene, goal, body, measured, thin)


def smoothed(motion: Motion, weight: float) -> Motion:
    """Return the motion without its jitter, under a Gaussian over time. weight: that of smoothness."""
    sigma = SMOOTHING * weight * motion.fps / 30
    if sigma < 0.1 or len(motion) < 3:
        return motion
    return motion.smoothed(sigma)


def blended(motion: Motion, refined: Motion, share: float) -> Motion:
    """Blend between a motion (share 0) and the refined one (share 1)."""
    turns = rotation.slerp(motion.rotations, refined.rotations, share)
    return replace(motion, root=motion.root + share * (refined.root - motion.root), rotations=turns)


def windows(frames: int, fps: float, stage: int = 0) -> list[tuple[int, int]]:
    """Return the windows (first, last + 1) of a take; each begins OVERLAP seconds before the previous one ends.

    The windows of the second stage lie across the seams of the first.
    """
    size, step = round(WINDOW * fps), round((WINDOW - OVERLAP) * fps)
    if frames <= round(1.5 * WINDOW * fps):
        return [(0, frames)]
    over = size - step
    seams = list(range(step if stage == 0 else step // 2, frames - step // 2, step))
    starts, ends = [0, *seams], [*(seam + over for seam in seams), frames]
    return [(first, min(last, frames)) for first, last in zip(starts, ends, strict=True)]


def _optimise(
    motion: Motion,
    scene: Field,
    body: Human,
    settings: Settings,
    goal: Goal | None,
    feet: list[FootPlan],
    stage: int,
    progress: Progress,
    thin: ThinThings | None,
    hands: Sequence[HandContact],
) -> Motion:
    """Return the motion after one stage of gradient descent, window by window, each blended into the next."""
    from .optimiser import SCALES, Optimiser  # imports torch
    from .pose import changed

    weights = {name: value for name, value in asdict(settings).items() if name in SCALES}
    resting = np.zeros(len(motion))
    resting[max(0, len(motion) - 1 - round(RESTING_SECONDS * motion.fps)) :] = goal is not None
    shift, turn = np.zeros((len(motion), 3)), np.zeros((len(motion), skeleton.BODY_COUNT, 3))
    spans = windows(len(motion), motion.fps, stage)
    for number, (first, last) in enumerate(spans):
        part = slice(first, last)
        optimiser = Optimiser(
            motion.pose_slice(part), body, scene, weights, [plan.cut(part) for plan in feet],
            goal if resting[part].any() else None, resting[part],
            thin=thin.afresh() if thin is not None and settings.thin else None,
            hands=palm.at_frames(hands, first, last - 1) if settings.hand else (),
        )  # fmt: skip
        report = lambda share, n=number: progress(
            "Refining", 0.05 + 0.42 * (stage + (n + share) / len(spans))
        )
        changes = optimiser.solve(stage, report)
        share = np.ones(last - first)
        if number:
            overlap = spans[number - 1][1] - first
            share[:overlap] = smoothstep(np.arange(1, overlap + 1) / (overlap + 1))
        shift[part] += share[:, None] * (changes[0] - shift[part])
        turn[part] += share[:, None, None] * (changes[1] - turn[part])
    return changed(motion, shift, turn)


def _require_finite(motion: Motion) -> None:
    """Raise SampError where a key is not finite."""
    for name, values in (("root", motion.root[:, None]), ("", motion.rotations)):
        wrong = np.argwhere(~np.isfinite(values).all(-1))
        if len(wrong):
            frame, joint = wrong[0]
            bone = name or skeleton.JOINTS[joint]
            raise SampError(
                f"Frame {frame} of the take has no finite value for '{bone}'; correct or delete that key."
            )


def _thin_things(
    motion: Motion, surroundings: Surroundings, body: Human, scene: Field, goal: Goal | None
) -> ThinThings | None:
    """Return the surfaces around a motion, sampled, without its floor; None where there are none."""
    from .thin_things import ThinThings  # imports torch

    seat = goal if goal is not None and goal.action == "sit" else None
    return ThinThings.around(motion, surroundings.triangles, surroundings.give, body, scene.floor, seat)


def _field(motion: Motion, surroundings: Surroundings, body: Human) -> Field:
    """Return the distances of what the character may touch. Raises SampError where nothing is near."""
    low, high = extent(motion.root)
    low, high = low - 1.2 - REACH, high + 1.2 + REACH
    near = solids.overlapping_box(surroundings.triangles, low, high)
    if not len(near):
        raise SampError(
            "No visible object is within a metre of the character; show the furniture and the floor, or move the take."
        )
    rows = np.linspace(0, len(motion) - 1, min(len(motion), 16)).astype(int)
    few = body.collision[:: max(1, len(body.collision) * len(rows) // OUTSIDE_SAMPLES // 8)]
    free = human.skin(body, motion.pose_slice(rows), few).reshape(-1, 3).astype(np.float64)
    scene = Field(surroundings.triangles, surroundings.give, surroundings.floor, free)
    floor = lowest_ground(motion, scene) if surroundings.floor is None else None
    # Most floors are planes, which have no inside: they are made solid below the lowest stance.
    return scene if floor is None else Field(surroundings.triangles, surroundings.give, floor, free)


def _result(
    motion: Motion,
    refined: Motion,
    surroundings: Surroundings,
    scene: Field,
    goal: Goal | None,
    body: Human,
    measured: bool,
    thin: ThinThings | None,
) -> Refined:
    """Measure a refined motion and its input."""
    floor = NO_FLOOR if scene.floor is None else scene.floor
    numbers = [
        metrics.measure(one, goal, surroundings.obstacles, floor, body) if measured else {}
        for one in (motion, refined)
    ]
    skin = human.skin(body, refined, body.collision).reshape(-1, 3)
    left = float(max(-scene.at(skin)[0].min(), 0.0))
    if thin is not None:
        left = max(left, thin.deepest(refined.pose_slice(slice(None, None, LOOKED_AT))))
    notes = ()
    if left > UNSOLVED:
        notes = (
            f"The body is still {left * 100:.0f} cm deep in the scene; move the furniture or the character.",
        )
    return Refined(refined, *numbers, left, notes)
