"""Retarget motions to bodies of different shapes, with feet in place and buttocks on the seat."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from ....samp_addon import rotation, skeleton
from ....samp_addon.body import human
from ....samp_addon.motion import Motion
from ....samp_addon.refine.feet.foot import sole_points
from ....samp_addon.refine.inverse_kinematics import solve_limb
from ...fitting.shapes import probes
from ...mocap.events import headings
from .bank import LABELS
from .blending import Piece

SHAPES = ("male", "female", "tall", "short", "heavy", "thin", "muscular", "elder")
MOST = {
    "male": 1.0,
    "female": 0.4,
    "tall": 0.5,
    "short": 0.2,
    "heavy": 0.3,
    "thin": 0.6,
    "muscular": 0.4,
    "elder": 0.5,
}
OPPOSITES = (("male", "female"), ("tall", "short"), ("heavy", "thin"))
SITS, LIES = (tuple(LABELS.index(n) for n in names) for names in (("sit",), ("lie",)))
EVEN, EARLY = 5.0, 31  # frames: sigma of the transition to sitting, and window by which it starts early
RESERVE = 0.007  # metres by which all bodies are raised on a seat, since most fits use the whole tolerance
FOLLOWS = 1.5  # frames, sigma with which the pelvis follows the feet
THICKEST = 99  # percentile of the touching skin whose distance to the default human's is compensated
_SEATED = (("left_hip", -85), ("right_hip", -85), ("left_knee", 85), ("right_knee", 85))


@dataclass(frozen=True)
class Build:
    """A body shape.

    shape: (8,) values in the order of SHAPES. body: the default human with them. seat, back: metres by which its pelvis
    is higher on a seat than the default human's, and farther in front of the support of its back.
    """

    shape: np.ndarray
    body: human.Human
    seat: float
    back: float


def draw(rng: np.random.Generator, share: float = 1.0) -> Build:
    """Return a random moderate build with one of each pair of opposites. share: factor on all values."""
    values = dict.fromkeys(SHAPES, 0.0)
    for pair in OPPOSITES:
        name = pair[int(rng.integers(2))]
        values[name] = MOST[name] * (rng.random() if name in ("male", "female") else rng.random() ** 1.5)
    for name in ("muscular", "elder"):
        if rng.random() < 0.4:
            values[name] = MOST[name] * rng.random()
    return of(share * np.array([values[name] for name in SHAPES]))


def of(shape: np.ndarray) -> Build:
    """Return the build of shape values (8,)."""
    body = human.load().shaped({name: float(v) for name, v in zip(SHAPES, shape, strict=True) if v})
    under, behind = _seated_skin(body)
    default_under, default_behind = _default_skin()
    thicker = [
        float(np.percentile(a - b, THICKEST)) for a, b in ((default_under, under), (default_behind, behind))
    ]
    return Build(np.asarray(shape), body, *(value + RESERVE for value in thicker))


@functools.cache
def _default_skin() -> tuple[np.ndarray, np.ndarray]:
    return _seated_skin(human.load())


def _seated_skin(body: human.Human) -> tuple[np.ndarray, np.ndarray]:
    """Return, for an upright seated pose, heights of the skin under buttocks and thighs over the pelvis joint, and
    positions of the back's skin in front of it, metres."""
    rotations = np.zeros((1, skeleton.BODY_COUNT, 4))
    rotations[..., 0] = 1
    for name, degrees in _SEATED:
        rotations[0, skeleton.INDEX[name]] = rotation.from_axis_angle(np.radians([degrees, 0.0, 0.0]))
    found = probes.load()
    motion = Motion(np.zeros((1, 3)), rotations)
    under = human.skin(body, motion, found.skin[found.seat])[0]
    return under[:, 1], human.skin(body, motion, found.skin[found.back])[0, :, 2]


def _resting(labels: np.ndarray, which: tuple[int, ...]) -> np.ndarray:
    """Return smooth weights (T,) of the frames with some labels, which rise before and fall after them."""
    flags = np.isin(labels, which).astype(float)
    return gaussian_filter1d(maximum_filter1d(flags, EARLY), EVEN, mode="nearest")


def on_default(
    root: np.ndarray, rotations: np.ndarray, labels: np.ndarray, build: Build
) -> tuple[np.ndarray, np.ndarray]:
    """Return root (T, 3) and rotations (T, 22, 4) of a motion on a build, retargeted to the default human.

    The inverse of `carried`; feet have to be locked again. labels: (T,) indices into bank.LABELS.
    """
    default, rest = skeleton.default_rest_joints(), build.body.joints
    joints, _ = skeleton.forward_kinematics(root, rotations, rest)
    sits, lies = _resting(labels, SITS), _resting(labels, LIES)
    share = np.clip(sits + lies, 0, 1)
    legs = build.body.floor / human.load().floor
    yaw = headings(root, rotations)
    back = root.copy()
    back[:, 1] += (1 - share) * (1 / legs - 1) * root[:, 1] - sits * build.seat - lies * build.back
    back -= (sits * build.back)[:, None] * np.column_stack([np.sin(yaw), np.zeros(len(yaw)), np.cos(yaw)])
    own, _ = skeleton.forward_kinematics(back, rotations, default)
    turned = rotations
    for side in ("left", "right"):
        ankle = skeleton.INDEX[f"{side}_ankle"]
        over = (default[ankle, 1] - human.load().floor) - (rest[ankle, 1] - build.body.floor)
        target = own[:, ankle].copy()
        target[:, 1] += share * (joints[:, ankle, 1] + over - target[:, 1])
        turned = solve_limb(back, turned, default, f"{side}_leg", target)
    return back, rotation.continuous(np.where(share[:, None, None] > 1e-3, turned, rotations))


def _carried_height(joints: np.ndarray, turned: np.ndarray, rest: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Return smooth heights (T,), metres, over the floor of the soles that carry the body.

    The pelvis follows them: a correction of 3 mm by the foot lock is 5 degrees in a nearly straight knee. joints:
    (T, J, 3). turned: (T, J, 4) global quaternions. feet: (T, 2) contacts of right and left foot.
    """
    lowest = np.stack(
        [
            np.minimum(*(end[:, 1] for end in sole_points(joints, turned, rest, side)))
            for side in ("right", "left")
        ],
        -1,
    )
    weight = np.where(feet > 0.5, 1.0, 1e-3)
    height = (weight * lowest).sum(1) / weight.sum(1)
    carrying = np.flatnonzero((feet > 0.5).any(1))
    if not len(carrying):
        return np.zeros(len(joints))
    every = np.interp(np.arange(len(joints)), carrying, height[carrying])
    return gaussian_filter1d(every, FOLLOWS, mode="nearest")


def carried(piece: Piece, build: Build) -> Piece:
    """Return the motion on a body of this build: strides by leg length, feet on the floor, pelvis on its seat."""
    default, rest = skeleton.default_rest_joints(), build.body.joints
    joints, _ = skeleton.forward_kinematics(piece.root, piece.rotations, default)
    sits, lies = _resting(piece.labels, SITS), _resting(piece.labels, LIES)
    stands = np.clip(1 - sits - lies, 0, 1)
    legs = build.body.floor / human.load().floor
    root = piece.root.copy()
    root[:, 1] += stands * (legs - 1) * root[:, 1] + sits * build.seat + lies * build.back
    yaw = headings(piece.root, piece.rotations)
    root += (sits * build.back)[:, None] * np.column_stack([np.sin(yaw), np.zeros(len(yaw)), np.cos(yaw)])
    # Standing and walking keep their angles: strides scale with the legs, and the foot lock fixes the feet.
    own, turned = skeleton.forward_kinematics(root, piece.rotations, rest)
    over_floor = stands * _carried_height(own, turned, rest, piece.feet)
    root[:, 1] -= over_floor
    own[..., 1] -= over_floor[:, None]
    share = np.clip(sits + lies, 0, 1)[:, None]
    rotations = piece.rotations
    for side in ("left", "right"):
        ankle = skeleton.INDEX[f"{side}_ankle"]
        over = (rest[ankle, 1] - build.body.floor) - (default[ankle, 1] - human.load().floor)
        # Legs keep their angles, except as needed by feet on the floor or on a rung.
        target = own[:, ankle].copy()
        target[:, 1] += share[:, 0] * (joints[:, ankle, 1] + over - target[:, 1])
        rotations = solve_limb(root, rotations, rest, f"{side}_leg", target)
    rotations = np.where(share[..., None] > 1e-3, rotations, piece.rotations)
    return Piece(
        root,
        rotation.continuous(rotations),
        piece.labels,
        piece.feet,
        piece.source,
        piece.hands,
        piece.object,
    )
