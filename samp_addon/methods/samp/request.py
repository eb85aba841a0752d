"""What a method is asked for."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...motion import Goal, Motion


@dataclass(frozen=True)
class Request:
    """One take asked of a method; all in the network frame, metres, radians.

    start_position: (3,) floor under the character; start_yaw: its facing. action: one of motion.ACTIONS.
    goal: where the pelvis shall end; for walk, run and idle a place on the floor. waypoints: (N, 3) of the path
    from the start towards the goal. object_triangles: (F, 3, 3) of the target, or None. object_yaw: its front.
    seed: of its noise. hold_seconds: how long the action is held at its end. style: standard deviation of the
    noise z, 0.1 as in SAMP. after: the motion that the take goes on from, at 30 frames a second; left out, the
    character stands at the start.
    """

    start_position: np.ndarray
    start_yaw: float
    action: str
    goal: Goal
    waypoints: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    object_triangles: np.ndarray | None = None
    object_yaw: float = 0.0
    seed: int = 0
    hold_seconds: float = 2.0
    style: float = 0.1
    after: Motion | None = None
