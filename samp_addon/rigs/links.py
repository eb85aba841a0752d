"""The bones of a rig that get keys, and which of them each one turns with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .. import skeleton
from ..errors import SampError
from . import maps, spines
from .rig import Rig


def key_links(rig: Rig, at: Mapping[str, int]) -> list[spines.Link]:
    """Return the links of all bones that get keys, parents before children. at: joint -> index of its bone."""
    spine, neck = spines.spine_and_neck(rig, at)
    trunk = [spines.Link(at["pelvis"], "pelvis", "pelvis", 1.0), *spine, *neck]
    done = {link.bone for link in trunk}
    skipped = {"pelvis", "neck", *spines.SPINE}
    others = [
        spines.Link(at[joint], joint, joint, 1.0)
        for joint in maps.JOINTS
        if joint in at and joint not in skipped
    ]
    return trunk + [link for link in others if link.bone not in done]


def link_parents(rig: Rig, links: Sequence[spines.Link]) -> np.ndarray:
    """Return the index of the link that each link turns with (K,).

    It is the first link above or, where bones between the two are constrained, that of the parent joint; -1 for the
    pelvis and for bones that keep their own direction. Raises SampError for a bone that is not below the pelvis.
    """
    place = {link.bone: k for k, link in enumerate(links)}
    result = np.full(len(links), -1)
    for k, link in enumerate(links[1:], start=1):
        bone, constrained = link.bone, False
        while bone >= 0 and (bone == link.bone or bone not in place):
            if not rig.inherits[bone] and not constrained:
                break
            constrained |= bone != link.bone and bool(rig.constrained[bone])
            bone = int(rig.parents[bone])
        else:
            if constrained:
                result[k] = _parent_joint_link(links, k)
            elif bone >= 0:
                result[k] = place[bone]
            else:
                raise SampError(
                    f"The bone '{rig.names[link.bone]}' of '{rig.name}' is not below the pelvis bone "
                    f"'{rig.names[links[0].bone]}'; correct the bone table."
                )
    return result


def _parent_joint_link(links: Sequence[spines.Link], k: int) -> int:
    """Return the index among links[:k] of the link of the nearest joint above that of link k."""
    trunk = ("pelvis", *spines.SPINE, "neck")
    if links[k].above in trunk:
        return k - 1
    joint = skeleton.PARENTS[skeleton.INDEX[links[k].above]]
    while joint >= 0:
        name = skeleton.JOINTS[joint]
        found = [n for n, link in enumerate(links[:k]) if link.above == name]
        if found:
            return found[-1]
        joint = skeleton.PARENTS[joint]
    return 0
