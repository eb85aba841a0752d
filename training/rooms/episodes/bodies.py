"""Bodies of different shapes: a motion carried to one, feet where they were, buttocks on the seat."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ....samp_addon import rotation, skeleton
from ....samp_addon.body import human
from ....samp_addon.motion import Motion
from ....samp_addon.refine.inverse_kinematics import solve_limb
from .bank import LABELS
from .blending import Piece

SHAPES = ("male", "female", "tall", "short", "heavy", "thin", "muscular", "elder")
MOST = {
    "male": 1.0,
    "female": 1.0,
    "tall": 0.5,
    "short": 0.5,
    "heavy": 0.45,
    "thin": 0.6,
    "muscular": 0.5,
    "elder": 0.6,
}
OPPOSITES = (("male", "female"), ("tall", "short"), ("heavy", "thin"))
SITS, LIES = (tuple(LABELS.index(n) for n in names) for names in (("sit",), ("lie",)))
EVEN = 7.0  # frames over which standing turns into sitting
_SEATED = (("left_hip", -85), ("right_hip", -85), ("left_knee", 85), ("right_knee", 85))


@dataclass(frozen=True)
class Build:
    """shape: (8,) values in the order of SHAPES. body: the default human with them. seat, bed: metres by which its
    pelvis is higher on a seat or a bed than the default human's."""

    shape: np.ndarray
    body: human.Human
    seat: float
    bed: float


def draw(rng: np.random.Generator) -> Build:
    """A random build: one of each pair of opposites, moderate."""
    values = dict.fromkeys(SHAPES, 0.0)
    for pair in OPPOSITES:
        name = pair[int(rng.integers(2))]
        values[name] = MOST[name] * (rng.random() if name in ("male", "female") else rng.random() ** 1.5)
    for name in ("muscular", "elder"):
        if rng.random() < 0.4:
            values[name] = MOST[name] * rng.random()
    return of(np.array([values[name] for name in SHAPES]))


def of(shape: np.ndarray) -> Build:
    """The build of values (8,)."""
    default = human.load()
    body = default.shaped({name: float(v) for name, v in zip(SHAPES, shape, strict=True) if v})
    return Build(
        np.asarray(shape), body, _under(body, True) - _base(True), _under(body, False) - _base(False)
    )


@functools.cache
def _base(seated: bool) -> float:
    return _under(human.load(), seated)


def _under(body: human.Human, seated: bool) -> float:
    """Metres from the pelvis joint down to the skin that it rests on, seated or lying on the back."""
    rotations = np.zeros((1, skeleton.BODY_COUNT, 4))
    rotations[..., 0] = 1
    if seated:
        for name, degrees in _SEATED:
            rotations[0, skeleton.INDEX[name]] = rotation.from_axis_angle(np.radians([degrees, 0.0, 0.0]))
    skin = human.skin(body, Motion(np.zeros((1, 3)), rotations))[0]
    owner = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], 1)[:, 0]
    near = np.isin(owner, [0, 1, 2]) & (np.abs(skin[:, 0]) < 0.14)
    near &= (skin[:, 2] < 0.1) if seated else (np.abs(skin[:, 1]) < 0.12)
    axis = 1 if seated else 2
    return float(-np.percentile(skin[near][:, axis], 1))


def carried(piece: Piece, build: Build) -> Piece:
    """The motion on a body of this build: legs as long as they are, feet on the floor, pelvis on its seat."""
    default, rest = skeleton.default_rest_joints(), build.body.joints
    joints, _ = skeleton.forward_kinematics(piece.root, piece.rotations, default)
    soft = lambda flags: gaussian_filter1d(np.isin(piece.labels, flags).astype(float), EVEN, mode="nearest")
    sits, lies = soft(SITS), soft(LIES)
    stands = np.clip(1 - sits - lies, 0, 1)
    legs = build.body.floor / human.load().floor
    root = piece.root.copy()
    root[:, 1] += stands * (legs - 1) * root[:, 1] + sits * build.seat + lies * build.bed
    rotations = piece.rotations
    for side in ("left", "right"):
        ankle = skeleton.INDEX[f"{side}_ankle"]
        over = (rest[ankle, 1] - build.body.floor) - (default[ankle, 1] - human.load().floor)
        target = joints[:, ankle] + [0.0, over, 0.0]
        rotations = solve_limb(root, rotations, rest, f"{side}_leg", target)
    return Piece(
        root,
        rotation.continuous(rotations),
        piece.labels,
        piece.feet,
        piece.source,
        piece.hands,
        piece.object,
    )
