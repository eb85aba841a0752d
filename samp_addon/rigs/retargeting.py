"""Retargeting of a take to a rig: same rotations, the pelvis at the height of the rig's legs, feet where they stood.

In the T-pose a rig is an SMPL-X body of other proportions (fitting.py). So a take for it is a Motion
(refine/proportions/carrying.py). Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .. import frames, rotation, skeleton
from ..body.hands import complete
from ..motion import Motion
from ..refine.feet.foot import FEET
from ..refine.proportions.carrying import Build, carry
from ..refine.proportions.hips import seat_depth
from .fitting import Fit, fit
from .rig import Rig


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A take on a rig.

    motion: of a body of the rig's proportions. location: (T, 3) of the pelvis bone, and rotations: (T, K, 4) of the
    fit's links, in the channels of their pose bones. planned: (T, 2, 3) places of the ankles, right one first, in the
    frames of stands: (T, 2) flags.
    """

    fit: Fit
    motion: Motion
    location: np.ndarray
    rotations: np.ndarray
    planned: np.ndarray
    stands: np.ndarray

    def missed(self) -> float:
        """Return the greatest distance of a standing foot from its planned place, which its leg does not reach."""
        positions, _ = self.motion.forward_kinematics()
        away = np.linalg.norm(positions[:, [foot.ankle for foot in FEET]] - self.planned, axis=-1)
        return float(away[self.stands].max(initial=0.0))


def retarget(
    motion: Motion, rig: Rig, bones: Mapping[str, str], skin: np.ndarray | None = None
) -> Retargeted:
    """Retarget a take to a rig.

    bones: joint -> bone name. skin: (N, 3) of the take's own body in the T-pose, the pelvis at the origin, if known.
    Raises SampError where the bones are not those of a body.
    """
    motion = replace(motion, rotations=complete(motion.rotations))
    fitted = fit(rig, bones, motion.rest_joints)
    thick = None if skin is None else seat_depth(skin, motion.rest_joints)
    carried = carry(motion, Build.over_soles(fitted.joints, fitted.sole, fitted.seat), thick)
    location, rotations = _channels(carried.motion, rig, fitted)
    return Retargeted(fitted, carried.motion, location, rotations, carried.planned, carried.stands)


def _channels(body: Motion, rig: Rig, fitted: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Return the location (T, 3) of the pelvis bone and the rotations (T, K, 4) of the links, as pose channels."""
    _, globals_ = body.forward_kinematics()
    turns = np.empty((len(body), len(fitted.links), 4))
    for k, link in enumerate(fitted.links):
        below, above = (globals_[:, skeleton.INDEX[joint]] for joint in (link.below, link.above))
        turned = above if link.share == 1.0 else rotation.slerp(below, above, link.share)
        turns[:, k] = rotation.multiply(turned, fitted.aligned[k])
    border = rotation.matrix_to_quaternion(rig.turn.T @ frames.BLENDER_FROM_NETWORK @ fitted.axes.T)
    result = np.empty_like(turns)
    for k, (link, parent) in enumerate(zip(fitted.links, fitted.parents, strict=True)):
        own = turns[:, k]
        if parent >= 0:
            own = rotation.multiply(rotation.conjugate(turns[:, parent]), own)
        own = rotation.change_basis(own, fitted.axes)
        if parent < 0:
            own = rotation.multiply(border, own)
        result[:, k] = rotation.change_basis(own, rig.bases[link.bone].T)
    pelvis = fitted.links[0].bone
    head = body.root + rotation.rotate(globals_[:, 0], np.broadcast_to(fitted.pelvis_bone, body.root.shape))
    inverse = np.linalg.inv(rig.world)
    place = frames.to_blender(head) @ inverse[:3, :3].T + inverse[:3, 3]
    return (place - rig.heads[pelvis]) @ rig.bases[pelvis], result
