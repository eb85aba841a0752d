"""Refine: contact, penetration, foot slide and smoothness of any take mended (Long-term motion, section 3.4)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from functools import cached_property

import numpy as np

from .. import rotation, skeleton
from ..body import human
from ..body.human import Human
from ..easing import smoothstep
from ..errors import SampError
from ..evaluation import metrics
from ..evaluation.obstacles import Obstacles
from ..motion import Goal, Motion
from ..progress import Progress
from ..scene.distance import solids
from ..scene.geometry import extent
from .field import Field
from .standing import FootPlan, lowest_ground, plan_feet, stand
from .weight import settled

SMOOTHED = 4.0  # frames of 30 a second of the Gaussian over time, for each unit of the weight of smoothness
WINDOW, OVERLAP = 8.0, 1.0  # seconds
REACH = 1.0  # metres around the character in which something has to be
SOME = 500  # vertices in all that tell what is outside
RESTING_SECONDS = 1.0
UNDERGROUND = -1e3
LAST_EVEN = 0.04  # seconds; what still hovers does so by little
UNSOLVED = 0.02  # metres


@dataclass(frozen=True)
class Settings:
    """Weights of the energies in the two stages (appendix 2), and how much is changed.

    foot, collision, contact, smooth: of equations 5 to 7 and of the foot's location; the first stage leaves the
    foot out. close: of staying with the input. limits: of joints past their limits. goal: of the pelvis on its
    goal. strength: share of the change that is kept, 0 to 1.
    """

    foot: float = 1.0
    collision: float = 1.0
    contact: float = 1.0
    smooth: float = 0.25
    close: float = 1.0
    limits: float = 1.0
    goal: float = 1.0
    strength: float = 1.0


@dataclass(frozen=True)
class Surroundings:
    """What a take is refined against, network frame.

    triangles: (F, 3, 3), metres. give: (F,) metres that the triangle's object yields under a body (its cushion
    depth). floor: height under which all is solid, or None where the triangles hold all floors.
    """

    triangles: np.ndarray
    give: np.ndarray
    floor: float | None = None

    @cached_property
    def obstacles(self) -> Obstacles:
        """For the measures; the takes in one scene share what is found out about it."""
        return Obstacles(self.triangles)


@dataclass(frozen=True)
class Refined:
    """A refined take. before, after: measures of both (evaluation.metrics.measure). unsolved: metres that the body
    is still deep in the scene somewhere, 0 where it is out. notes: sentences for the artist."""

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
) -> Refined:
    """The motion, refined. body: whose skin counts; the default human if left out.

    What progress raises stops the work. Raises SampError for a motion with numbers that are none, and where there
    is no scene near. measured: whether before and after are filled in.
    """
    settings, body = settings or Settings(), body or human.load()
    _require_sound(motion)
    progress("Looking at the scene", 0.0)
    field_ = _field(motion, surroundings, body)
    mended = smoothed(motion, settings.smooth)
    if settings.contact > 0:
        mended = settled(mended, field_, body)
    feet = None
    for stage in (0, 1):
        feet = plan_feet(mended, field_, feet)
        mended = _optimised(mended, field_, body, settings, goal, feet, stage, progress)
    progress("Feet", 0.9)
    if settings.foot > 0:
        mended = stand(mended, feet, field_)
    if settings.contact > 0:
        mended = settled(mended, field_, body, LAST_EVEN)
    if settings.strength < 1:
        mended = blended(motion, mended, settings.strength)
    progress("Measuring", 0.95)
    return _told(motion, mended, surroundings, field_, goal, body, measured)


def smoothed(motion: Motion, weight: float) -> Motion:
    """The motion without its tremble: a Gaussian over time."""
    sigma = SMOOTHED * weight * motion.fps / 30
    if sigma < 0.1 or len(motion) < 3:
        return motion
    return motion.smoothed(sigma)


def blended(motion: Motion, refined: Motion, share: float) -> Motion:
    """Between a motion (share 0) and the refined one (share 1)."""
    turns = rotation.slerp(motion.rotations, refined.rotations, share)
    return replace(motion, root=motion.root + share * (refined.root - motion.root), rotations=turns)


def windows(frames: int, fps: float, stage: int = 0) -> list[tuple[int, int]]:
    """First and last + 1 frames of the windows of a take; each begins OVERLAP seconds before the last one ends.

    Those of the second stage lie across the seams of the first.
    """
    size, step = round(WINDOW * fps), round((WINDOW - OVERLAP) * fps)
    if frames <= round(1.5 * WINDOW * fps):
        return [(0, frames)]
    over = size - step
    seams = list(range(step if stage == 0 else step // 2, frames - step // 2, step))
    starts, ends = [0, *seams], [*(seam + over for seam in seams), frames]
    return [(first, min(last, frames)) for first, last in zip(starts, ends, strict=True)]


def _optimised(
    motion: Motion,
    field_: Field,
    body: Human,
    settings: Settings,
    goal: Goal | None,
    feet: list[FootPlan],
    stage: int,
    progress: Progress,
) -> Motion:
    """The motion after a stage of gradient descent, window by window, each faded into the next."""
    from .optimiser import SCALES, Optimiser  # torch is imported on first use
    from .pose import changed

    weights = {name: value for name, value in asdict(settings).items() if name in SCALES}
    resting = np.zeros(len(motion))
    resting[max(0, len(motion) - 1 - round(RESTING_SECONDS * motion.fps)) :] = goal is not None
    shift, turn = np.zeros((len(motion), 3)), np.zeros((len(motion), skeleton.BODY_COUNT, 3))
    spans = windows(len(motion), motion.fps, stage)
    for number, (first, last) in enumerate(spans):
        part = slice(first, last)
        optimiser = Optimiser(
            motion.pose_slice(part), body, field_, weights, [_cut_plan(plan, part) for plan in feet],
            goal if resting[part].any() else None, resting[part],
        )  # fmt: skip
        told = lambda share, n=number: progress("Refining", 0.05 + 0.42 * (stage + (n + share) / len(spans)))
        moved = optimiser.solve(stage, told)
        share = np.ones(last - first)
        if number:
            known = spans[number - 1][1] - first
            share[:known] = smoothstep(np.arange(1, known + 1) / (known + 1))
        shift[part] += share[:, None] * (moved[0] - shift[part])
        turn[part] += share[:, None, None] * (moved[1] - turn[part])
    return changed(motion, shift, turn)


def _cut_plan(plan: FootPlan, part: slice) -> FootPlan:
    return replace(
        plan, ankle=plan.ankle[part], turned=plan.turned[part], standing=plan.standing[part], stances=()
    )


def _require_sound(motion: Motion) -> None:
    for name, values in (("root", motion.root[:, None]), ("", motion.rotations)):
        wrong = np.argwhere(~np.isfinite(values).all(-1))
        if len(wrong):
            frame, joint = wrong[0]
            bone = name or skeleton.JOINTS[joint]
            raise SampError(f"Frame {frame} of the take has no number for '{bone}'; mend or delete that key.")


def _field(motion: Motion, surroundings: Surroundings, body: Human) -> Field:
    """What the character may touch. Raises SampError where nothing is near."""
    low, high = extent(motion.root)
    low, high = low - 1.2 - REACH, high + 1.2 + REACH
    near = solids.overlapping_box(surroundings.triangles, low, high)
    if not len(near):
        raise SampError(
            "Nothing stands within a metre of the character; show the furniture and the floor, or refine elsewhere."
        )
    rows = np.linspace(0, len(motion) - 1, min(len(motion), 16)).astype(int)
    few = body.collision[:: max(1, len(body.collision) * len(rows) // SOME // 8)]
    free = human.skin(body, motion.pose_slice(rows), few).reshape(-1, 3).astype(np.float64)
    field_ = Field(surroundings.triangles, surroundings.give, surroundings.floor, free)
    floor = lowest_ground(motion, field_) if surroundings.floor is None else None
    # Most floors are planes, which have no inside of their own.
    return field_ if floor is None else Field(surroundings.triangles, surroundings.give, floor, free)


def _told(
    motion: Motion,
    refined: Motion,
    surroundings: Surroundings,
    field_: Field,
    goal: Goal | None,
    body: Human,
    measured: bool,
) -> Refined:
    """What came of it, in numbers."""
    floor = UNDERGROUND if field_.floor is None else field_.floor
    numbers = [
        metrics.measure(one, goal, surroundings.obstacles, floor, body) if measured else {}
        for one in (motion, refined)
    ]
    skin = human.skin(body, refined, body.collision).reshape(-1, 3)
    left = float(max(-field_.at(skin)[0].min(), 0.0))
    notes = ()
    if left > UNSOLVED:
        notes = (
            f"The body is still {left * 100:.0f} cm deep in the scene; move the furniture or the character.",
        )
    return Refined(refined, *numbers, left, notes)
