"""The body as graphs of 22, 11, 5 and 1 nodes, and the links between them (section 3.2.2; the paper has 19 joints)."""

from __future__ import annotations

import torch

from .kinematics import JOINTS, PARENTS

_GROUPS_OF_JOINTS = (
    (0, 3, 6), (9, 13, 14), (12, 15), (1, 4), (7, 10), (2, 5), (8, 11), (16,), (18, 20), (17,), (19, 21),
)  # fmt: skip
_GROUPS_OF_PARTS = ((0, 1, 2), (3, 4), (5, 6), (7, 8), (9, 10))  # trunk and head, legs, arms
LEVELS = (JOINTS, len(_GROUPS_OF_JOINTS), len(_GROUPS_OF_PARTS), 1)


def adjacency(nodes: int) -> torch.Tensor:
    """Return the adjacency (nodes, nodes) of a level's nodes, 0 or 1, including each node itself."""
    links = torch.eye(JOINTS)
    for joint, parent in enumerate(PARENTS):
        if parent >= 0:
            links[joint, parent] = links[parent, joint] = 1
    for level, groups in ((1, _GROUPS_OF_JOINTS), (2, _GROUPS_OF_PARTS)):
        if LEVELS.index(nodes) >= level:
            member = _membership(groups, len(links))
            links = ((member @ links @ member.T) > 0).float()
    return torch.ones(1, 1) if nodes == 1 else links


def links(source: int, target: int) -> torch.Tensor:
    """Return the links (2, target, source) from the nodes of one level to those of the same or an adjacent one.

    The first matrix links a node with itself, its group or its members, the second one with their neighbours. Rows
    sum to 1, or to 0 where a node has no neighbours.
    """
    own = _own(source, target)
    near = (own @ adjacency(source) > 0).float() - (own > 0).float()
    return torch.stack([_rows(own), _rows(near.clamp(min=0))])


def _own(source: int, target: int) -> torch.Tensor:
    one, other = LEVELS.index(source), LEVELS.index(target)
    if one == other:
        return torch.eye(source)
    if one > other:
        return _own(target, source).T
    parts = {(0, 1): _GROUPS_OF_JOINTS, (1, 2): _GROUPS_OF_PARTS, (2, 3): (tuple(range(LEVELS[2])),)}
    return _membership(parts[one, other], source)


def _membership(groups: tuple[tuple[int, ...], ...], members: int) -> torch.Tensor:
    made = torch.zeros(len(groups), members)
    for row, group in enumerate(groups):
        made[row, list(group)] = 1
    return made


def _rows(weights: torch.Tensor) -> torch.Tensor:
    return weights / weights.sum(1, keepdim=True).clamp(min=1)
