"""Postures of lying other than supine, derived from the captured reclines: on the side, and half sitting.

No capture shows them. The descent is captured; the roll onto the side, the arms and the legs are synthesised here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....samp_addon import rotation, skeleton
from ....samp_addon.easing import smoothstep
from ...composition.recline import Recline
from ...mocap.clip_files import Clip
from ...mocap.events import uprightness
from ..shapes import posing, probes

POSTURES = {"back": 0.6, "side": 0.2, "half": 0.2}  # shares of the tries
ROLL = 40  # frames in which a supine body rolls onto its side
HOLD = 110  # frames of lying still
ROLLED = np.radians(82)  # angle of the roll
RAISED = 0.08  # metres by which the pelvis joint is higher on a side than supine
HALF = np.cos(np.radians(46))  # cosine between the chest and the vertical at which a body half sits
LAP = 30  # frames in which hands move into the lap
BREATH = np.radians(0.7), 105  # amplitude of the chest's pitch, and period in frames, of breathing
SIDES = {"left": 1.0, "right": -1.0}
BEHIND = (0.16, 0.75)  # heights (m) over the mattress of the support of a half sitting back
STRIP = 0.22  # metres to either side of the body
BIN = 0.05  # height (m) of a bin of the headboard's face
FARTHEST = 0.8  # largest shift of a body along the bed, metres


def on_side(recline: Recline, lower: str) -> Recline:
    """Return the recline continued onto the left or right side, knees bent, arms in front."""
    clip = recline.clip.cut(0, recline.still + 1)
    joints, _ = skeleton.forward_kinematics(clip.root[-1:], clip.rotations[-1:], posing.REST)
    along = joints[0, skeleton.INDEX["neck"]] - joints[0, 0]
    along /= np.linalg.norm(along)
    last = clip.rotations[-1]
    share = smoothstep(np.arange(1, ROLL + 1) / ROLL)
    # Seen from the feet, a supine body that rolls to its left turns clockwise about the direction to its head.
    turn = rotation.from_axis_angle(share[:, None] * along * ROLLED * SIDES[lower])
    rotations = np.stack(
        [_toward(last[j], wanted, share) for j, wanted in enumerate(_side_pose(last, lower))], 1
    )
    rotations[:, 0] = rotation.multiply(turn, np.broadcast_to(last[0], (ROLL, 4)))
    rolled = _continued(clip, clip.root[-1] + RAISED * share[:, None] * [0.0, 1.0, 0.0], rotations)
    return Recline(_held(rolled), len(rolled) - 1)


def half_sitting(recline: Recline) -> Recline:
    """Return the recline stopped half way, as against a headboard, with hands in the lap."""
    down = np.flatnonzero(uprightness(recline.clip) > HALF)
    clip = recline.clip.cut(0, int(down[-1]) + 1)
    last = clip.rotations[-1]
    share = smoothstep(np.arange(1, LAP + 1) / LAP)
    wanted = last.copy()
    for side, out in SIDES.items():
        wanted[skeleton.INDEX[f"{side}_shoulder"]] = _about(2, -out * 68)
        wanted[skeleton.INDEX[f"{side}_elbow"]] = _about(1, -out * 62)
    for name in ("neck", "head"):
        wanted[skeleton.INDEX[name]] = rotation.multiply(last[skeleton.INDEX[name]], _about(0, 6))
    rotations = np.stack([_toward(last[j], wanted[j], share) for j in range(len(last))], 1)
    # The trunk's remaining speed decays.
    root = clip.root[-1] + np.cumsum((1 - share)[:, None] * (clip.root[-1] - clip.root[-2]), 0)
    laid = _continued(clip, root, rotations)
    return Recline(_held(laid), len(laid) - 1)


def variants(reclines: list[Recline]) -> dict[str, list[Recline]]:
    """Return the reclines of the other postures."""
    return {
        "side": [on_side(recline, lower) for recline in reclines for lower in SIDES],
        "half": [half_sitting(recline) for recline in reclines],
    }


def to_headboard(
    clip: Clip, still: np.ndarray, surface: np.ndarray, mattress: float, to_feet: np.ndarray
) -> float | None:
    """Return the shift, metres, that brings a half sitting body to the headboard of its bed; None without one.

    clip, surface (N, 3): in the piece's frame. still: (T,) flags. to_feet: (3,) horizontal direction.
    """
    frame = int(np.flatnonzero(still)[len(np.flatnonzero(still)) // 2])
    back = probes.skinned(clip.root[[frame]], clip.rotations[[frame]], probes.load().upper_back)[0]
    across = np.array([to_feet[2], 0.0, -to_feet[0]])
    middle = clip.root[frame]
    height = surface[:, 1] - mattress
    near = (np.abs((surface - middle) @ across) < STRIP) & (height > BEHIND[0]) & (height < BEHIND[1])
    behind = near & ((surface - middle) @ to_feet < 0.1)
    if behind.sum() < 50:
        return None
    # The face consists of the points nearest to the feet at each height.
    level = ((surface[behind, 1] - mattress) / BIN).astype(int)
    face = np.full(int(BEHIND[1] / BIN) + 1, -np.inf)
    np.maximum.at(face, level, (surface[behind] - middle) @ to_feet)
    at = np.clip(((back[:, 1] - mattress) / BIN).astype(int), 0, len(face) - 1)
    gap = (back - middle) @ to_feet - face[at]
    gap = gap[np.isfinite(gap) & (back[:, 1] - mattress > BEHIND[0])]
    if len(gap) < 5 or not abs(np.sort(gap)[2]) < FARTHEST:
        return None
    return float(np.sort(gap)[2])


def _side_pose(last: np.ndarray, lower: str) -> np.ndarray:
    """Return the local rotations (22, 4) of lying on a side."""
    pose = last.copy()
    for name in ("spine1", "spine2", "spine3", "neck", "head"):
        pose[skeleton.INDEX[name]] = _about(0, 7)
    for side, out in SIDES.items():
        upper = side != lower
        bent = np.radians(58 if upper else 42)
        # The upper leg is lowered onto the lower one.
        inwards = np.array([0.0, -np.sin(bent), -np.cos(bent)]) * out * (np.radians(15) if upper else 0.0)
        pose[skeleton.INDEX[f"{side}_hip"]] = rotation.multiply(
            rotation.from_axis_angle(inwards), rotation.from_axis_angle(np.array([-bent, 0.0, 0.0]))
        )
        pose[skeleton.INDEX[f"{side}_knee"]] = _about(0, 74 if upper else 62)
        pose[skeleton.INDEX[f"{side}_ankle"]] = _about(0, 18)
        pose[skeleton.INDEX[f"{side}_collar"]] = _about(1, -out * 8)
        pose[skeleton.INDEX[f"{side}_shoulder"]] = _about(1, -out * (112 if upper else 68))
        pose[skeleton.INDEX[f"{side}_elbow"]] = _about(1, -out * (48 if upper else 92))
    return pose


def _about(axis: int, degrees: float) -> np.ndarray:
    return rotation.from_axis_angle(np.radians(degrees) * np.eye(3)[axis])


def _toward(start: np.ndarray, end: np.ndarray, share: np.ndarray) -> np.ndarray:
    end = end if start @ end >= 0 else -end
    return rotation.slerp(
        np.broadcast_to(start, (len(share), 4)), np.broadcast_to(end, (len(share), 4)), share
    )


def _continued(clip: Clip, root: np.ndarray, rotations: np.ndarray) -> Clip:
    count = len(root)
    more = lambda values: np.concatenate([values, np.repeat(values[-1:], count, 0)])
    return replace(
        clip, root=np.concatenate([clip.root, root]),
        rotations=rotation.continuous(np.concatenate([clip.rotations, rotations])), labels=more(clip.labels),
        feet=more(clip.feet), bad=more(clip.bad),
    )  # fmt: skip


def _held(clip: Clip) -> Clip:
    """Return the clip with its last pose held, with breathing."""
    pitch = BREATH[0] * np.sin(2 * np.pi * np.arange(1, HOLD + 1) / BREATH[1])
    rotations = np.repeat(clip.rotations[-1:], HOLD, 0)
    rotations = posing.pitched(rotations, "spine2", pitch)
    rotations = posing.pitched(rotations, "neck", -pitch)
    return _continued(clip, np.repeat(clip.root[-1:], HOLD, 0), rotations)
