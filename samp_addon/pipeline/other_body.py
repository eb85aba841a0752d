"""Takes for the body that shows them: methods make them for bodies of proportions that they know."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..body.human import Human
from ..methods.take import Take
from ..refine.proportions import carrying


def fitted(take: Take, body: Human) -> Take:
    """Return a take for a body: its motion, and where its goal and its sub-goals are for the pelvis of this body."""
    motion = carrying.for_body(take.motion, body)
    if motion is take.motion:
        return take
    moved = motion.root - take.motion.root
    goal, places = take.goal, take.sub_goals
    if goal is not None:
        goal = replace(goal, position=np.asarray(goal.position) + moved[-1])
    if places is not None:
        places = tuple(replace(place, position=place.position + moved[place.frame]) for place in places)
    return replace(take, motion=motion, goal=goal, sub_goals=places)
