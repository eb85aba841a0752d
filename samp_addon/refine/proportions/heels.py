"""Raised heels of a body that sits on a seat too high for its shins. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ... import rotation
from ...motion import Motion
from ..feet.plan import FootPlan
from ..inverse_kinematics import at_height

MOST = 0.06
"""Metres by which an ankle is raised at most; the foot then stands on its ball, pitched by about 30 degrees."""

SHARE = 2.0
"""Metres by which an ankle is raised for each metre by which the knee is too low: thighs that just touch the front edge
of the seat in the source, thicker or thinner, do not press into it with a little more."""


def raised(plans: Sequence[FootPlan], body: Motion, source: Motion, rests: np.ndarray) -> list[FootPlan]:
    """Return plans of feet whose heels are raised until the knees are as high as in the source, or a little higher.

    Heights of knees are from the hips. With flat feet, shorter shins would press the thighs into the front edge of the
    seat. Knees that are level with the hips are high enough. body: with the proportions of the plans. source: the take
    that it shows. rests: (T,) share with which the body rests.
    """
    found, wanted = (motion.forward_kinematics()[0] for motion in (body, source))
    made = []
    for plan in plans:
        foot = plan.foot
        drop, allowed = (joints[:, foot.hip, 1] - joints[:, foot.knee, 1] for joints in (found, wanted))
        rise = rests * np.clip(SHARE * (drop - np.maximum(allowed, 0.0)), 0.0, MOST)
        made.append(_on_its_ball(plan, rise, body.rest_joints))
    return made


def _on_its_ball(plan: FootPlan, rise: np.ndarray, rest_joints: np.ndarray) -> FootPlan:
    """Return a plan whose foot is pitched about its ball until the ankle is higher by rise (T,)."""
    ball = plan.ball(rest_joints)
    back = plan.ankle - ball
    height = np.minimum(back[:, 1] + rise, np.linalg.norm(back, axis=-1))
    turn = rotation.between(back, at_height(back, height, back[:, [0, 2]]))
    return replace(
        plan, ankle=ball + rotation.rotate(turn, back), orientation=rotation.multiply(turn, plan.orientation)
    )
