"""Gradient descent on a whole take against its scene (Long-term motion, section 3.4 and appendix 2), in two stages.

The scene is looked at every few steps; between looks each vertex knows its distance and the way out, which is all
that gradient descent takes from it anyhow, and a hundred times as fast. Network frame, metres.
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
from .field import Field
from .pose import Pose, Skin, changed, rotation_matrices, spline_basis
from .standing import FootPlan, ball
from .weight import TOUCHING, carried

STEPS = (40, 80)  # of the two stages
LOOK = 10  # steps between two looks at the scene
PATIENCE = 3  # looks without gain after which a stage is done
RATES = (0.006, 0.012)  # of Adam: metres of the root, radians of the joints
GROUND = 10.0  # of leaving the ground, beside staying with the input
BETAS = (0.9, 0.999)
MARGIN = 0.006  # metres that skin keeps off things
SOLE_THICKNESS, SOLE_MARGIN = 0.02, -0.012  # soles are put onto the ground afterwards, see standing.py
ACTIVE = 0.06  # metres from a surface within which a vertex is watched
HELD = 200.0  # vertices that weigh as much as a metre between a body and what carries it
TOUCH_FROM = 0.05  # metres from a surface within which skin is drawn to it
ENOUGH = 1e-2  # relative gain below which there is none
# How much an energy's unit weighs beside the others: metres of all vertices together, counts of vertices, metres of
# joints, squared radians, squared metres.
SCALES = {
    "collision": 5.0,
    "contact": 0.01,
    "smooth": 0.05,
    "close": 1.0,
    "foot": 30.0,
    "limits": 20.0,
    "goal": 30.0,
}
# What people move first: limbs before the trunk.
STIFFNESS = {"spine1": 3.0, "spine2": 3.0, "spine3": 3.0, "neck": 1.5, "head": 1.5, "pelvis": 4.0, "hip": 1.5,
             "knee": 1.0, "ankle": 1.0, "foot": 0.5, "collar": 1.5, "shoulder": 0.6, "elbow": 0.5,
             "wrist": 0.5}  # fmt: skip
# Joints whose skin rests on things: who sits or lies wants these in touch, not the hands.
RESTING = ("pelvis", "hip", "knee", "spine1", "spine2", "spine3", "head")
STILL = 0.6  # m/s of the pelvis from which on nothing is rested on
_FEET = [skeleton.INDEX[f"{side}_{name}"] for name in ("ankle", "foot") for side in ("right", "left")]


@dataclass
class Watched:
    """Vertices near things. row, vertex: (N,) frame number among those looked at, and vertex. place, way: (N, 3) where
    it was seen and the way out; distance: (N,). rests: (N,) flags of skin that rests on things. nearest: numbers
    among the N of the nearest in each frame that something has to carry."""

    row: torch.Tensor
    vertex: torch.Tensor
    place: torch.Tensor
    way: torch.Tensor
    distance: torch.Tensor
    rests: torch.Tensor
    nearest: torch.Tensor


@dataclass(frozen=True)
class Looks:
    """How closely the scene is looked at: every so many steps, in so many frames a second, for vertices that were once
    nearer than so many metres. The benchmark compares this with all of everything."""

    every: int = LOOK
    a_second: float = 15.0  # the changes between are smooth
    near: float = 1.5 * ACTIVE


class Optimiser:
    """One take, or a window of one, and what is changed of it."""

    def __init__(
        self,
        motion: Motion,
        body: Human,
        field: Field,
        weights: dict[str, float],
        feet: list[FootPlan],
        goal: Goal | None,
        resting: np.ndarray,
        looks: Looks | None = None,
    ) -> None:
        """weights: of the energies by their names in SCALES. resting: (T,) frames that rest on the goal."""
        self.looks = looks or Looks()
        self.motion, self.body, self.field, self.weights = motion, body, field, weights
        self.pose = Pose(motion, body)
        self.skin = Skin(body, body.collision)
        step = max(1, round(motion.fps / self.looks.a_second))
        self.rows = torch.arange(0, len(motion), step)
        tensor = lambda a: torch.tensor(np.asarray(a), dtype=torch.float32)
        self.basis = tensor(spline_basis(len(motion), motion.fps))
        count = self.basis.shape[1]
        self.root_knots = torch.zeros(count, 3, requires_grad=True)
        self.turn_knots = torch.zeros(count, skeleton.BODY_COUNT, 3, requires_grad=True)
        self.feet_at = tensor(
            np.stack([plan.ankle for plan in feet] + [ball(plan, motion) for plan in feet], 1)
        )
        self.standing = tensor(np.stack([plan.standing for plan in feet] * 2, 1))
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
        self.carried = carried(motion)[self.rows.numpy()]
        with torch.no_grad():
            none = torch.zeros(len(motion), 3), torch.zeros(len(motion), skeleton.BODY_COUNT, 3)
            self.before, _ = self.pose.joints(*none)
        self.watched: Watched | None = None

    def changes(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Shift (T, 3) of the root and turn (T, 22, 3) of the joints."""
        return self.basis @ self.root_knots, (self.basis @ self.turn_knots.flatten(1)).unflatten(1, (-1, 3))

    def solve(
        self, stage: int, progress: Callable[[float], None] = lambda share: None
    ) -> tuple[np.ndarray, np.ndarray]:
        """One of the two stages, 0 or 1. Returns shift (T, 3) and turn (T, 22, 3); progress is told the share done."""
        with single_thread():
            self._descend(stage, progress)
        with torch.no_grad():
            shift, turn = self.changes()
        return shift.numpy().astype(np.float64), turn.numpy().astype(np.float64)

    def _descend(self, stage: int, progress: Callable[[float], None]) -> None:
        """Gradient descent on the knots."""
        steps = STEPS[stage]
        adam = Adam([self.root_knots, self.turn_knots], RATES)
        values: list[float] = []
        for step in range(steps):
            if step % self.looks.every == 0:
                self.look()
                values.append(float(self.loss(stage).detach()))
                if self._is_done(values):
                    break
            self.loss(stage).backward()
            adam.step(1 - 0.9 * step / steps)
            progress(step / steps)

    def _is_done(self, values: Sequence[float]) -> bool:
        """Whether the losses of the last looks are no better than those before."""
        waited = PATIENCE * LOOK // self.looks.every
        return len(values) > waited and min(values[-waited:]) > (1 - ENOUGH) * min(values[:-waited])

    def loss(self, stage: int) -> torch.Tensor:
        """All energies with their weights; the first stage leaves the feet's places out."""
        shift, turn = self.changes()
        placed, turned = self.pose.joints(shift, turn)
        watched, frames = self.watched, len(self.rows)
        skin = self.skin.at(self.pose.transforms(placed, turned, self.rows), watched.row, watched.vertex)
        distance = watched.distance + ((skin - watched.place) * watched.way).sum(-1)
        parts = {
            "collision": energies.collision(distance, self.margin[watched.vertex], frames),
            "contact": energies.contact(distance[watched.rests], TOUCHING, frames)
            + HELD * energies.held(distance.index_select(0, watched.nearest), TOUCHING, frames),
            "smooth": energies.smoothness(placed - self.before) * self.motion.fps / 30,
            "close": energies.closeness(shift, turn, self.stiffness),
            "limits": energies.joint_limits(self.pose.local @ rotation_matrices(turn), self.limits),
        }
        feet = placed[:, _FEET], self.feet_at, self.standing
        if stage == 0:
            parts["close"] = parts["close"] + GROUND * energies.on_ground(*feet)
        else:
            parts["foot"] = energies.foot_location(*feet)
        if self.goal is not None:
            parts["goal"] = energies.on_goal(placed, *self.goal, self.resting)
        return sum(SCALES[name] * self.weights[name] * value for name, value in parts.items())

    def look(self) -> None:
        """Where the skin is now, and how far from things."""
        with torch.no_grad():
            shift, turn = (c.numpy().astype(np.float64) for c in self.changes())
        rows = self.rows.numpy()
        moved = changed(self.motion, shift, turn)
        thin = moved.pose_slice(rows)
        skin = human.skin(self.body, thin, self.body.collision)
        if self.watched is None:
            self._near = np.flatnonzero(self.field.at(skin.reshape(-1, 3))[0] < self.looks.near)
        points = skin.reshape(-1, 3)[self._near]
        distance, way = self.field.at(points)
        close = distance < (ACTIVE if np.isfinite(self.looks.near) else np.inf)
        chosen, points, distance, way = self._near[close], points[close], distance[close], way[close]
        length = np.linalg.norm(way, axis=-1, keepdims=True)
        row, vertex = np.divmod(chosen, skin.shape[1])
        tensor = lambda a: torch.tensor(a, dtype=torch.float32)
        self.watched = Watched(
            torch.as_tensor(row), torch.as_tensor(vertex), tensor(points), tensor(way / np.maximum(length, 1.0)),
            tensor(distance), self.rests[vertex] & self.still[row] & torch.as_tensor(distance < TOUCH_FROM),
            torch.as_tensor(self._nearest(row, distance)),
        )  # fmt: skip

    def _nearest(self, row: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Which of the vertices, in order of their rows (N,), is nearest in each row that something carries."""
        order = np.lexsort((distance, row))
        first = order[np.unique(row[order], return_index=True)[1]]
        return first[self.carried[row[first]]]


class Adam:
    """Kingma and Ba's gradient descent. torch's own takes seconds to load, for a compiler that is not used here."""

    def __init__(self, tensors: Sequence[torch.Tensor], rates: Sequence[float]) -> None:
        self.tensors, self.rates, self.count = tensors, rates, 0
        self.means = [(torch.zeros_like(t), torch.zeros_like(t)) for t in tensors]

    @torch.no_grad()
    def step(self, share: float) -> None:
        """One step of the tensors down their gradients, with this share of the rates; the gradients are cleared."""
        self.count += 1
        for tensor, rate, (first, second) in zip(self.tensors, self.rates, self.means, strict=True):
            first.lerp_(tensor.grad, 1 - BETAS[0])
            second.lerp_(tensor.grad.square(), 1 - BETAS[1])
            mean, square = (m / (1 - b**self.count) for m, b in zip((first, second), BETAS, strict=True))
            tensor.sub_(share * rate * mean / (square.sqrt() + 1e-8))
            tensor.grad = None


def _by_joint(table: dict[str, float]) -> np.ndarray:
    """Numbers (22,) by the names of joints without their sides."""
    return np.array([table[name.split("_")[-1]] for name in skeleton.BODY_JOINTS])


def _rests(body: Human) -> np.ndarray:
    """Flags of the collision vertices that rest on things: those on the back and underneath of RESTING joints."""
    main = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], axis=1)[:, 0][
        body.collision
    ]
    joints = [j for j, name in enumerate(skeleton.BODY_JOINTS) if name.split("_")[-1] in RESTING]
    behind = body.vertices[body.collision][:, 2] < body.joints[main][:, 2]
    return np.isin(main, joints) & behind
