"""Gradient descent on a whole take against its scene (Long-term motion, section 3.4 and appendix 2), in two stages.

The scene is sampled every few steps. Between samples the distance of each vertex is linear along its gradient, which
is all that gradient descent uses, and a hundred times as fast. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from .. import skeleton
from ..body import human
from ..body.human import Human
from ..body.joint_limits import limits
from ..motion import Goal, Motion
from ..torch_threads import single_thread
from . import energies
from .feet.plan import FootPlan
from .field import Field
from .hands.palm import HandContact, offset
from .hovering import TOUCHING, supported
from .pose import Along, Pose, Skin, changed, spline_basis
from .thin_things import ThinThings

STEPS = (40, 80)  # of the two stages
SAMPLE_EVERY = 10  # steps between two samples of the scene
THIN_EVERY = 2  # samples of the scene from one to the next of thin things, which cost more
PATIENCE = 3  # samples without gain after which a stage ends
RATES = (0.006, 0.012)  # of Adam: metres of the root, radians of the joints
GROUND = 10.0  # weight of feet that leave the ground, relative to closeness to the input
BETAS = (0.9, 0.999)
MARGIN = 0.006  # metres between skin and surfaces
SOLE_THICKNESS, SOLE_MARGIN = 0.02, -0.012  # soles are put onto the ground afterwards, see feet/
ACTIVE = 0.06  # metres from a surface within which a vertex is included
SUPPORT = 200.0  # vertices that weigh as much as a metre between a body and what supports it
TOUCH_FROM = 0.05  # metres from a surface within which skin is attracted to it
MIN_GAIN = 1e-2  # relative gain below which a sample counts as one without gain
# Relative weights of the energies, whose units differ: metres summed over vertices, counts of vertices, metres of
# joints, squared radians, squared metres.
SCALES = {
    "collision": 5.0,
    "thin": 2.5,  # samples of surfaces are denser than vertices
    "contact": 0.01,
    "smooth": 0.05,
    "close": 1.0,
    "foot": 30.0,
    "hand": 30.0,
    "limits": 20.0,
    "goal": 30.0,
}
# Stiffness of each joint: people move their limbs before their trunk.
STIFFNESS = {"spine1": 3.0, "spine2": 3.0, "spine3": 3.0, "neck": 1.5, "head": 1.5, "pelvis": 4.0, "hip": 1.5,
             "knee": 1.0, "ankle": 1.0, "foot": 0.5, "collar": 1.5, "shoulder": 0.6, "elbow": 0.5,
             "wrist": 0.5}  # fmt: skip
# Joints whose skin rests on surfaces while sitting or lying; hands do not.
RESTING = ("pelvis", "hip", "knee", "spine1", "spine2", "spine3", "head")
STILL = 0.6  # m/s of the pelvis, below which the body can rest on something
_FEET = [skeleton.INDEX[f"{side}_{name}"] for name in ("ankle", "foot") for side in ("right", "left")]


@dataclass
class NearVertices:
    """Vertices near surfaces, as last sampled.

    distance: (N,) metres, linear along its gradient. along: the vertices in the direction of the gradient. margin: (N,)
    metres to keep. rests: (N,) flags of skin that rests on surfaces. nearest: indices among the N of the nearest vertex
    in each frame in which the body is supported.
    """

    distance: torch.Tensor
    along: Along
    margin: torch.Tensor
    rests: torch.Tensor
    nearest: torch.Tensor

    def distance_at(self, transforms: torch.Tensor) -> torch.Tensor:
        """Return the distances (N,) under other transforms (3, 4, R, 55) of the joints."""
        return self.distance + self.along.at(transforms)


@dataclass(frozen=True)
class Sampling:
    """How densely the scene is sampled: every ``every`` steps, in ``rate`` frames per second, for vertices that were
    within ``near`` metres at first. The benchmark compares the default with all vertices, frames and steps."""

    every: int = SAMPLE_EVERY
    rate: float = 15.0  # the changes between frames are smooth
    near: float = 1.5 * ACTIVE


class Optimiser:
    """The optimisation of one take, or of a window of one."""

    def __init__(
        self,
        motion: Motion,
        body: Human,
        field: Field,
        weights: dict[str, float],
        feet: list[FootPlan],
        goal: Goal | None,
        resting: np.ndarray,
        sampling: Sampling | None = None,
        thin: ThinThings | None = None,
        hands: Sequence[HandContact] = (),
    ) -> None:
        """weights: by the names in SCALES. resting: (T,) 1 in frames that rest on the goal, else 0. thin: surface
        samples that are kept out of the body, or None. hands: that stay on what they are on."""
        self.sampling = sampling or Sampling()
        self.motion, self.body, self.field, self.weights = motion, body, field, weights
        self.pose = Pose(motion, body)
        self.skin = Skin(body, body.collision)
        step = max(1, round(motion.fps / self.sampling.rate))
        self.rows = torch.arange(0, len(motion), step)
        tensor = lambda a: torch.tensor(np.asarray(a), dtype=torch.float32)
        self.basis = tensor(spline_basis(len(motion), motion.fps))
        count = self.basis.shape[1]
        self.root_knots = torch.zeros(count, 3, requires_grad=True)
        self.turn_knots = torch.zeros(count, skeleton.BODY_COUNT, 3, requires_grad=True)
        self.feet_at = tensor(
            np.stack([plan.ankle for plan in feet] + [plan.ball(motion.rest_joints) for plan in feet], 1)
        )
        self.standing = tensor(np.stack([plan.standing for plan in feet] * 2, 1))
        self.hands = _hands(hands, body) if hands else None
        self.goal = None if goal is None else (tensor(goal.position), tensor(goal.direction))
        self.resting = tensor(resting)
        self.stiffness = tensor(_by_joint(STIFFNESS))
        self.limits = tensor(limits())
        self.rests = torch.tensor(_rests(body))
        soles = body.vertices[body.collision][:, 1] < body.floor + SOLE_THICKNESS
        self.margin = tensor(np.where(soles, SOLE_MARGIN, MARGIN))
        speed = (
            np.linalg.norm(np.gradient(motion.root, 1 / motion.fps, axis=0), axis=-1)
            if len(motion) > 1
            else [0]
        )
        self.still = torch.tensor(np.asarray(speed) < STILL)[self.rows]
        self.supported = supported(motion)[self.rows.numpy()]
        with torch.no_grad():
            still = self.pose.locally(torch.zeros(len(motion), skeleton.BODY_COUNT, 3))
            self.before, _ = self.pose.joints(torch.zeros(len(motion), 3), still)
        self.near: NearVertices | None = None
        self.thin, self.pierced, self._samplings = thin, None, 0

    def changes(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the shift (T, 3) of the root, metres, and the rotation vectors (T, 22, 3) of the joints."""
        return self.basis @ self.root_knots, (self.basis @ self.turn_knots.flatten(1)).unflatten(1, (-1, 3))

    def solve(
        self, stage: int, progress: Callable[[float], None] = lambda share: None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Run stage 0 or 1 and return the changes, see changes(). progress: called with the share done, from 0 to 1."""
        with single_thread():
            self._descend(stage, progress)
        with torch.no_grad():
            shift, turn = self.changes()
        return shift.numpy().astype(np.float64), turn.numpy().astype(np.float64)

    def _descend(self, stage: int, progress: Callable[[float], None]) -> None:
        """Run gradient descent on the knots."""
        steps = STEPS[stage]
        adam = Adam([self.root_knots, self.turn_knots], RATES)
        values: list[float] = []
        for step in range(steps):
            if step % self.sampling.every == 0:
                self.sample_scene()
                values.append(float(self.loss(stage).detach()))
                if self._has_converged(values):
                    break
            self.loss(stage).backward()
            adam.step(1 - 0.9 * step / steps)
            progress(step / steps)

    def _has_converged(self, values: Sequence[float]) -> bool:
        """Return whether the losses of the last samples are no better than those before."""
        waited = PATIENCE * SAMPLE_EVERY // self.sampling.every
        return len(values) > waited and min(values[-waited:]) > (1 - MIN_GAIN) * min(values[:-waited])

    def loss(self, stage: int) -> torch.Tensor:
        """Return the weighted sum of all energies; the first stage lets feet slide."""
        shift, turn = self.changes()
        local = self.pose.locally(turn)
        placed, turned = self.pose.joints(shift, local)
        near, frames = self.near, len(self.rows)
        transforms = self.pose.transforms(placed, turned, self.rows)
        distance = near.distance_at(transforms)
        parts = {
            "collision": energies.collision(distance, near.margin, frames),
            "contact": energies.contact(distance[near.rests], TOUCHING, frames)
            + SUPPORT * energies.support(distance.index_select(0, near.nearest), TOUCHING, frames),
            "smooth": energies.smoothness(placed - self.before) * self.motion.fps / 30,
            "close": energies.closeness(shift, turn, self.stiffness),
            "limits": energies.joint_limits(local, self.limits),
        }
        feet = placed[:, _FEET], self.feet_at, self.standing
        if self.pierced is not None:
            depth = self.pierced.depth_at(transforms)
            parts["thin"] = energies.pierced(depth, self.pierced.weight, frames)
        if stage == 0:
            parts["close"] = parts["close"] + GROUND * energies.on_ground(*feet)
        else:
            parts["foot"] = energies.foot_location(*feet)
        if self.hands is not None:
            wrists, tips, places, held = self.hands
            palms = placed[:, wrists] + (turned[:, wrists] @ tips[..., None])[..., 0]
            parts["hand"] = energies.foot_location(palms, places, held)
        if self.goal is not None:
            parts["goal"] = energies.on_goal(placed, *self.goal, self.resting)
        return sum(SCALES[name] * self.weights[name] * value for name, value in parts.items())

    def sample_scene(self) -> None:
        """Sample the distances of the present skin to the scene."""
        with torch.no_grad():
            shift, turn = (c.numpy().astype(np.float64) for c in self.changes())
        rows = self.rows.numpy()
        moved = changed(self.motion, shift, turn)
        sampled = moved.pose_slice(rows)
        skin = human.skin(self.body, sampled, self.body.collision)
        if self.thin is not None and self._samplings % THIN_EVERY == 0:
            self.pierced = self.thin.pierced(sampled)
        self._samplings += 1
        if self.near is None:
            self._candidates = np.flatnonzero(self.field.at(skin.reshape(-1, 3))[0] < self.sampling.near)
        points = skin.reshape(-1, 3)[self._candidates]
        distance, gradient = self.field.at(points)
        close = distance < (ACTIVE if np.isfinite(self.sampling.near) else np.inf)
        chosen, points = self._candidates[close], points[close]
        distance, gradient = distance[close], gradient[close]
        length = np.linalg.norm(gradient, axis=-1, keepdims=True)
        row, vertex = np.divmod(chosen, skin.shape[1])
        gradient = gradient / np.maximum(length, 1.0)
        self.near = NearVertices(
            torch.tensor(distance, dtype=torch.float32), self.skin.along(sampled, row, vertex, gradient),
            self.margin[vertex], self.rests[vertex] & self.still[row] & torch.as_tensor(distance < TOUCH_FROM),
            torch.as_tensor(self._nearest(row, distance)),
        )  # fmt: skip

    def _nearest(self, row: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Return the index of the nearest vertex in each row in which the body is supported. row: (N,), in order."""
        order = np.lexsort((distance, row))
        first = order[np.unique(row[order], return_index=True)[1]]
        return first[self.supported[row[first]]]


class Adam:
    """Adam (Kingma and Ba 2014). torch.optim takes seconds to import, for a compiler that is not used here."""

    def __init__(self, tensors: Sequence[torch.Tensor], rates: Sequence[float]) -> None:
        self.tensors, self.rates, self.count = tensors, rates, 0
        self.means = [(torch.zeros_like(t), torch.zeros_like(t)) for t in tensors]

    @torch.no_grad()
    def step(self, share: float) -> None:
        """Take one step with a share of the learning rates, and clear the gradients."""
        self.count += 1
        for tensor, rate, (first, second) in zip(self.tensors, self.rates, self.means, strict=True):
            first.lerp_(tensor.grad, 1 - BETAS[0])
            second.lerp_(tensor.grad.square(), 1 - BETAS[1])
            mean, square = (m / (1 - b**self.count) for m, b in zip((first, second), BETAS, strict=True))
            tensor.sub_(share * rate * mean / (square.sqrt() + 1e-8))
            tensor.grad = None


def _hands(
    hands: Sequence[HandContact], body: Human
) -> tuple[list[int], torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return the wrists (H) of hands, the palms in their frames (H, 3), their places (T, H, 3) and weights (T, H)."""
    tensor = lambda parts, axis: torch.tensor(np.stack(parts, axis), dtype=torch.float32)
    return (
        [skeleton.INDEX[f"{hand.side}_wrist"] for hand in hands],
        tensor([offset(body.joints, hand.side) for hand in hands], 0),
        tensor([hand.places for hand in hands], 1),
        tensor([hand.weight for hand in hands], 1),
    )


def _by_joint(table: dict[str, float]) -> np.ndarray:
    """Return the values (22,) of a table by joint name without side."""
    return np.array([table[name.split("_")[-1]] for name in skeleton.BODY_JOINTS])


def _rests(body: Human) -> np.ndarray:
    """Return flags of the collision vertices that rest on surfaces: those at the back of RESTING joints."""
    main = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], axis=1)[:, 0][
        body.collision
    ]
    joints = [j for j, name in enumerate(skeleton.BODY_JOINTS) if name.split("_")[-1] in RESTING]
    behind = body.vertices[body.collision][:, 2] < body.joints[main][:, 2]
    return np.isin(main, joints) & behind
