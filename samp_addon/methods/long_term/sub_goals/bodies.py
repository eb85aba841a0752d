"""Bodies at sub-goals (section 3.2): drawn from the network, put onto what carries them, and the best of them chosen.

Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from .... import rotation
from ....body import betas as shapes
from ....body import hand_poses, human, proportions
from ....motion import Motion
from ....vocabulary import CONTACTS, SEATED
from ..figure import Figure, as_motion
from ..surfaces import Surfaces
from . import places, settling
from .places import Place

if TYPE_CHECKING:
    from ..networks import Networks

DRAWS = 12
"""Bodies that are drawn for one place; one of the best is taken, the best one on furniture."""
NEAR_BEST = 0.004
"""Cost in metres by which a standing body that is taken may be worse than the best one. It cannot be seen."""
AROUND = 1.25
"""Metres around a body from which its cloud is taken."""
OFF_PHASE = 0.04
"""Metres of depth that weigh as much as a radian beside the wanted phase."""
PLAIN, WILD = 0.6, 1.0
"""Standard deviation of the noise at the least and at the largest style."""


def noise_scale(style: float) -> float:
    """Return the standard deviation of all noise for a style from 0 to 1."""
    return PLAIN + (WILD - PLAIN) * style


@dataclass(frozen=True)
class SubGoalBodies:
    """The bodies at the sub-goals of one scene, for the artist to look at before there is a take. betas: (10,)."""

    networks: Networks
    surfaces: Surfaces
    betas: np.ndarray
    _known: dict[tuple[float, ...], Place] = field(default_factory=dict, repr=False, compare=False)

    def place(self, point: np.ndarray, yaw: float, name: str) -> Place:
        """Return what carries the body at a point; see places.find. Found once: another body is drawn there soon."""
        key = (*map(float, point), float(yaw))
        if key not in self._known:
            self._known[key] = places.find(self.surfaces, point, yaw, name)
        return self._known[key]

    def facing(self, point: np.ndarray, wanted: float, name: str) -> float:
        """Return the facing at a point in radians; see places.facing."""
        return places.facing(self.surfaces, point, wanted, name)

    def draw(self, place: Place, number: int, style: float) -> Motion:
        """Return a body at a place, one frame, default proportions. number: of the draw."""
        rng = np.random.default_rng(number)
        figure = choose(self.networks, self.surfaces, place, self.betas, rng, noise_scale(style))
        return _in_default(figure, place)

    def posed(self, place: Place, pose: Motion) -> Motion:
        """Return a pose of one frame, default proportions, at a place: turned to its facing, and at the height at which
        it stands on the floor, or touches what carries it."""
        pose = proportions.adapt(pose, shapes.body_of(self.betas).joints)
        height, hands = float(place.floor[1]), hand_poses.read_hands(pose.rotations)[0]
        figure = Figure(place.pelvis, pose.rotations[0, :22], hands, self.betas, height)
        turns = figure.rotations.copy()
        turns[0] = rotation.multiply(rotation.about_y(place.yaw - figure.facing(place.action)), turns[0])
        figure = Figure(place.pelvis, turns, hands, self.betas, height)
        if place.action in SEATED:
            figure = settling.settled([figure], self.surfaces.field, height)[0][0]
        else:
            figure = settling.grounded(figure, height)
        return _in_default(figure, place)


def _in_default(figure: Figure, place: Place) -> Motion:
    """Return a figure at a place as a Motion of one frame in the default proportions."""
    contacts = np.zeros((1, len(CONTACTS)))
    contacts[0, CONTACTS.index("pelvis")] = place.action in SEATED
    return proportions.adapt(replace(as_motion([figure]), contacts=contacts), human.load().joints)


def choose(
    networks: Networks, surfaces: Surfaces, place: Place, betas: np.ndarray, rng: np.random.Generator,
    scale: float, phase: float | None = None, draws: int = DRAWS,
) -> Figure:  # fmt: skip
    """Return a body for a place.

    betas: (10,). scale: standard deviation of the noise. phase: of the gait, radians, where the place is walked
    through; None where the body stays.
    """
    from .. import networks as tools
    from ..networks import Wanted

    gait = np.zeros(2) if phase is None else np.array([np.cos(phase), np.sin(phase)])
    wanted = Wanted(place.action, place.pelvis, place.yaw, float(place.floor[1]), betas, gait)
    cloud = surfaces.cloud(place.pelvis[None], AROUND, wanted.level, int(rng.integers(2**31)))
    noise, turns = tools.body_noise(rng, draws, scale), tools.body_turns(rng, draws)
    drawn = networks.sample_bodies(wanted, cloud, noise, turns)
    field, floor = surfaces.field, float(place.floor[1])
    if place.action in SEATED:
        figures, costs = settling.settled(drawn, field, floor)
        best = figures[int(np.argmin(costs))]
        return settling.fitted(best, field, floor, place.action, int(rng.integers(2**31)))
    figures = [settling.grounded(figure, floor) for figure in drawn]
    costs = settling.fits(figures, field, floor)[:, 0]
    if phase is not None:
        read = np.array([tools.phase(figure) for figure in figures])
        off = np.arccos(np.clip(read @ gait, -1, 1))
        costs = costs + OFF_PHASE * off
    return figures[_near_best(costs, rng)]


def _near_best(costs: np.ndarray, rng: np.random.Generator) -> int:
    """Return a random one of the bodies that cost (K,) hardly more than the best one."""
    # Rounded: the last bits depend on the number of threads, and takes must not.
    return int(rng.choice(np.flatnonzero(np.round(costs - costs.min(), 5) <= NEAR_BEST)))
