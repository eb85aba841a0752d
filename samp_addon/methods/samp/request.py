"""The request for one take of SAMP."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...motion import Goal, Motion
from ...scene.flights import Flight


@dataclass(frozen=True)
class Request:
    """Request for one take; network frame, metres, radians.

    start_position: (3,) on the floor under the character; start_yaw: its facing. action: one of vocabulary.ACTIONS.
    goal: final position of the pelvis; for walk, run and idle a place on the floor. waypoints: (N, 3) of the path from
    the start towards the goal. object_triangles: (F, 3, 3) of the target, or None. object_front: returns the yaw of its
    front, which takes a while; networks whose grids are drawn around the goal do not call it. seed: of all that is
    drawn; latent_seed: of z alone, if that is to differ. hold_seconds: how long the action is held at the end. style:
    standard deviation of the noise z, 0.1 as in SAMP. after: the motion that the take continues, at 30 fps; without it
    the character stands at the start. lead: the end of ``after`` that is a part of the take: how the body gets up
    from a bed. remarks: sentences for the artist about what was asked for and is not done
    exactly. ground: returns the heights (N,) of the ground near points (N, 3), NaN where there is none; None for even
    ground. free: where the path leads through a narrow gap, returns the places (N, 3) nearest to points (N, 3) at which
    a body fits. posture: of the rest, see postures.py; drawn if empty. posture_places: returns the postures for which
    there is a place; only networks that know postures ask. table: returns the places (2, 3) of the left and the right
    wrist on a table in front of the goal, or None. flights: of stairs, on the way-points.
    """

    start_position: np.ndarray
    start_yaw: float
    action: str
    goal: Goal
    waypoints: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    object_triangles: np.ndarray | None = None
    object_front: Callable[[], float] = lambda: 0.0
    seed: int = 0
    hold_seconds: float = 2.0
    style: float = 0.1
    after: Motion | None = None
    lead: Motion | None = None
    remarks: tuple[str, ...] = ()
    ground: Callable[[np.ndarray], np.ndarray] | None = None
    free: Callable[[np.ndarray], np.ndarray] | None = None
    posture: tuple[str, ...] = ()
    posture_places: Callable[[], tuple[str, ...]] = tuple
    table: Callable[[], np.ndarray | None] = lambda: None
    latent_seed: int | None = None
    flights: Sequence[Flight] = ()
