"""Members that look at each other, or at something, once they have come to rest. Network frame, metres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ... import skeleton
from ...edits.look_at import look_at
from ...frames import direction_yaw
from ...methods.take import Take
from .role import Role

HEAD = skeleton.INDEX["head"]
EYES_OVER_HEAD = 0.06
"""Metres from the head joint up to the eyes of whom one looks at."""


def facing(roles: Sequence[Role]) -> list[Role]:
    """Return the roles, those that walk to a place without a facing turned to where whom they look at ends."""
    found = []
    for role in roles:
        destination, point = role.views[0][-1].destination, role.looks_at
        if isinstance(point, int):
            end = roles[point].views[0][-1].destination
            point = None if end is None else end[0]
        if destination is not None and destination[1] is None and point is not None:
            towards = (point - destination[0]) * [1.0, 0.0, 1.0]
            if np.linalg.norm(towards) > 0.1:
                role = role.ending((destination[0], float(direction_yaw(towards))))  # noqa: PLW2901
        found.append(role)
    return found


def looking(takes: Mapping[int, Take], roles: Sequence[Role], rested: Mapping[int, int]) -> dict[int, Take]:
    """Return the takes with heads turned. rested: the frame from which each member is at rest."""
    heads = {k: take.motion.forward_kinematics()[0][:, HEAD] for k, take in takes.items()}
    found = dict(takes)
    for k, take in takes.items():
        aim = roles[k].looks_at
        begin = rested[k]
        if isinstance(aim, int):
            if aim not in heads or aim == k:
                continue
            begin = max(begin, rested[aim])
            aim = heads[aim] + [0.0, EYES_OVER_HEAD, 0.0]
        if aim is None or begin >= len(take.motion):
            continue
        if aim.ndim == 2:
            aim = aim[np.minimum(np.arange(len(take.motion)), len(aim) - 1)]
        found[k] = replace(take, motion=look_at(take.motion, aim, begin))
    return found
