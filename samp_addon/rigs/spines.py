"""Spines and necks of any number of bones, and the distribution of SMPL-X's joints over them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .rig import Rig

SPINE = ("spine1", "spine2", "spine3")


@dataclass(frozen=True)
class Link:
    """A bone that turns between the joint ``below`` (share 0) and the joint ``above`` (share 1)."""

    bone: int
    below: str
    above: str
    share: float


def spine_and_neck(rig: Rig, at: Mapping[str, int]) -> tuple[list[Link], list[Link]]:
    """Return the links of the spine and of the neck, from below. at: joint -> index of its bone."""
    top = next((at[joint] for joint in ("neck", "head") if joint in at), None)
    spine = _between(rig, at["pelvis"], top, [at[joint] for joint in SPINE if joint in at])
    last = spine[-1] if spine else at["pelvis"]
    neck = _between(rig, last, at.get("head"), [at["neck"]] if "neck" in at else [])
    return _spread(spine, ("pelvis", *SPINE)), _spread(neck, ("spine3", "neck"))


def _between(rig: Rig, below: int, above: int | None, named: list[int]) -> list[int]:
    """Return the bones of a kinematic chain, from below.

    They are all bones between two bones or, where these do not include them, those that are named. Constrained bones
    are helpers and not part of the chain.
    """
    path = rig.above(above) if above is not None else []
    if below not in path:
        return named
    chain = [
        bone for bone in reversed(path[: path.index(below)]) if bone in named or not rig.constrained[bone]
    ]
    return chain if set(named) <= set(chain) else named


def _spread(chain: Sequence[int], joints: Sequence[str]) -> list[Link]:
    """Distribute the bend of joints[1:] over a chain; its last bone turns as the last joint does."""
    result, steps = [], len(joints) - 1
    for count, bone in enumerate(chain, start=1):
        along = count * steps / len(chain)
        low = min(int(along), steps - 1)
        result.append(Link(bone, joints[low], joints[low + 1], along - low))
    return result
