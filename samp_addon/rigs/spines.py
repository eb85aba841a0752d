"""Spines and necks of any number of bones: which bones they are, and how SMPL-X's joints are spread over them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .rig import Rig

SPINE = ("spine1", "spine2", "spine3")


@dataclass(frozen=True)
class Link:
    """A bone that turns as the joint ``above`` does, by ``share`` (0 to 1), and else as the joint ``below``."""

    bone: int
    below: str
    above: str
    share: float


def spine_and_neck(rig: Rig, at: Mapping[str, int]) -> tuple[list[Link], list[Link]]:
    """The links of the spine and those of the neck, from below, of a rig with bones ``at`` its joints."""
    top = next((at[joint] for joint in ("neck", "head") if joint in at), None)
    spine = _between(rig, at["pelvis"], top, [at[joint] for joint in SPINE if joint in at])
    last = spine[-1] if spine else at["pelvis"]
    neck = _between(rig, last, at.get("head"), [at["neck"]] if "neck" in at else [])
    return _spread(spine, ("pelvis", *SPINE)), _spread(neck, ("spine3", "neck"))


def _between(rig: Rig, below: int, above: int | None, named: list[int]) -> list[int]:
    """The bones of a chain, from below: all on the way between two bones, or those that are named, where the way
    leads past them. What constraints move is machinery, and no part of it."""
    way = rig.above(above) if above is not None else []
    if below not in way:
        return named
    chain = [bone for bone in reversed(way[: way.index(below)]) if bone in named or not rig.constrained[bone]]
    return chain if set(named) <= set(chain) else named


def _spread(chain: Sequence[int], joints: Sequence[str]) -> list[Link]:
    """Bones that share the bend of joints[1:] over joints[0]; the last one turns as the last joint does."""
    result, steps = [], len(joints) - 1
    for count, bone in enumerate(chain, start=1):
        along = count * steps / len(chain)
        low = min(int(along), steps - 1)
        result.append(Link(bone, joints[low], joints[low + 1], along - low))
    return result
