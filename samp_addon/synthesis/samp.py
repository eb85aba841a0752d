"""SAMP (papers/samp.txt): from a request to finished takes by the rollout of MotionNet."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .. import rotation, skeleton
from ..errors import RolloutError, SampError
from ..motion import ACTIONS, Motion
from ..progress import show
from ..scene.geometry import sample_surface
from ..scene.voxels import InteractionGrid
from . import finish
from .request import Request
from .resting import RestingTop
from .route import SPEED_UP, Route
from .seat_edge import SeatFront

if TYPE_CHECKING:
    from .rollout import Frame, Rollout

ARRIVED = 0.2  # metres from the goal
STILL = 0.25  # m/s of the pelvis: a seated body still shifts
SINKING = 0.06  # m/s of the pelvis' height: who still sinks or rises does not sit yet
PACES = {
    "walk": 1.25,
    "run": 2.4,
    "sit": 1.15,
    "lie": 1.15,
}  # m/s on a free stretch; furniture is walked up to slowly
SLOWEST = 0.45  # m/s that a character may average on its way before the take counts as stuck
GRACE = 10.0  # seconds on top, for turning, sitting down and settling
LYING_DOWN = 6.0  # seconds more to lie down
FPS = 30
SEATED_PELVIS, STANDING_PELVIS = 0.65, 0.85  # metres over the floor
MOST_DRIVE = 0.7  # m/s that the planned speed may be ahead of the body's
RISING = 0.15  # share of the pace at which somebody sets off who still sits
RECLINED = 0.6  # cosine of the chest's slope from which a body counts as lying
SURFACE_SAMPLES = 60_000  # of a piece that is sat or lain on
CHEST = skeleton.INDEX["spine3"]
RECORDED = ("pelvis", "matrices", "contacts", "actions", "roots")


@functools.cache
def load_network(folder: Path | None = None, kind: str = "motion_net") -> tuple:
    """The network in evaluation mode and its start poses: heights (K,) and local quaternions (K, 22, 4).

    folder: of other weights than the shipped ones. kind: one of models.baselines.NETWORKS.
    """
    import torch

    from ...models import weights
    from ...models.baselines import NETWORKS, hidden_width

    try:
        tensors = weights.load_weights("motion_net", folder or weights.FOLDER)
    except weights.WeightsError as error:
        raise SampError(str(error)) from error
    starts = tensors.pop("start_heights"), tensors.pop("start_rotations")
    net = NETWORKS[kind](hidden_width(tensors))
    # The encoder is needed for training only and is not shipped.
    net.load_state_dict({k: v.float() for k, v in tensors.items()}, strict=False)
    net.eval()
    torch.set_grad_enabled(True)
    return net, starts[0].float(), starts[1].float()


def generate(
    requests: Sequence[Request],
    progress: Callable[[float], None] = lambda share: None,
    network: tuple | None = None,
) -> list[Motion | SampError]:
    """One take for each request, all rolled out as one batch: the Motion, or the error that says what went wrong.

    progress is called with the share done, from 0 to 1, and shown the first take as it comes, see progress.py; what
    it raises stops the work. network: as load_network gives it; left out, the shipped one.
    """
    results: list[Motion | SampError] = [_refusal(request) for request in requests]
    sound = [k for k, refusal in enumerate(results) if refusal is None]
    for k, result in zip(
        sound,
        _run([requests[k] for k in sound], progress, network or load_network()) if sound else [],
        strict=True,
    ):
        results[k] = result
    return results


def _refusal(request: Request) -> SampError | None:
    """Why a request cannot be fulfilled at all, or None."""
    if request.action not in ACTIONS:
        return SampError(f"There is no action '{request.action}'; choose one of {', '.join(ACTIONS)}.")
    return None


@dataclass
class _Take:
    """What is decided for one take while it runs."""

    request: Request
    route: Route
    number: int = 0  # of the goal in force
    front: SeatFront | None = None
    top: RestingTop | None = None
    travelled: float = 0.0
    drive: float = 0.0
    risen: float = 1.0
    held: int = 0
    done_at: int | None = None

    @property
    def pace(self) -> float:
        """Metres a second: everybody has their own, and so has every take."""
        own = np.random.default_rng(self.request.seed).uniform(0.85, 1.15)
        return own * PACES.get(self.request.action, PACES["walk"])

    def goal(self) -> np.ndarray:
        """The goal in force (11,)."""
        return self.route.goals[self.number]

    def limit(self) -> int:
        """Frames after which the take counts as stuck."""
        more = LYING_DOWN if self.request.action == "lie" else 0.0
        return round((self.route.length / SLOWEST + GRACE + more + self.request.hold_seconds) * FPS)

    def update(
        self,
        root: np.ndarray,
        pelvis: np.ndarray,
        speed: float,
        sinking: float,
        weights: np.ndarray,
        upright: float,
        frame: int,
    ) -> None:
        """Passes way-points, and counts the frames in which the action is being held at the goal.

        speed, sinking: m/s of the pelvis and of its height. upright: cosine between the chest and the vertical.
        """
        self.travelled = self.route.project(root, self.travelled)
        # A plan made afresh from standing still says "soon" in every frame, and nobody ever sets off: the wish to be
        # under way grows while the body lags behind it.
        self.drive = min(self.drive + SPEED_UP / FPS, speed + MOST_DRIVE, self.pace)
        self.risen = float(
            np.clip((pelvis[1] - SEATED_PELVIS) / (STANDING_PELVIS - SEATED_PELVIS), RISING, 1.0)
        )
        last = len(self.route.goals) - 1
        while self.number < last:
            goal = self.goal()
            passed = self.travelled > self.route.along[self.number] + 0.05
            if np.hypot(*(root - goal[[0, 2]])) > self.route.radii[self.number] and not passed:
                break
            self.number += 1
        goal = self.goal()
        action = int(np.argmax(goal[6:]))
        radius = (2.0 if action == 0 else 1.5) * ARRIVED
        near = np.hypot(pelvis[0] - goal[0], pelvis[2] - goal[2]) < radius
        there = action == 0 or (weights[action] > 0.6 and sinking < SINKING)
        settled = self.number == last and near and speed < STILL and there
        if action == ACTIONS.index("lie"):
            settled &= upright < RECLINED
        self.held += int(settled)
        if self.held >= max(1, round(self.request.hold_seconds * FPS)) and self.done_at is None:
            self.done_at = frame


def _run(
    requests: Sequence[Request], progress: Callable[[float], None], network: tuple
) -> list[Motion | SampError]:
    """The batch, frame by frame, until every take is done or has used up its time."""
    import torch

    from . import steering

    takes = _takes(requests)
    limit = max(take.limit() for take in takes)
    recorded: dict[str, list[np.ndarray]] = {name: [] for name in RECORDED}
    with torch.inference_mode():
        run = _rollout(takes, network)
        follow, steer = steering.guides(takes)
        for frame in range(limit):
            run.set_goals(torch.as_tensor(np.stack([take.goal() for take in takes]), dtype=torch.float32))
            new = run.step(follow, steer)
            for name, values in recorded.items():
                values.append(getattr(new, name).numpy().copy())
            _update(takes, recorded, frame)
            if frame % 5 == 0:
                progress(_share_done(takes, frame, limit))
                show(progress, _glimpse(takes[0], new))
            if all(take.done_at is not None or frame >= take.limit() for take in takes):
                break
    arrays = {name: np.stack(values) for name, values in recorded.items()}
    return [_finished(take, {name: a[:, k] for name, a in arrays.items()}) for k, take in enumerate(takes)]


def _glimpse(take: _Take, frame: Frame) -> Motion:
    """The newest frame of the first take, on the floor that it walks on."""
    matrices = frame.matrices[0].double().numpy()
    local = skeleton.local_rotations(rotation.matrix_to_quaternion(matrices)[None])
    root = frame.pelvis[0].double().numpy() + [0.0, take.route.points[0][1], 0.0]
    return Motion(root[None], local)


def _takes(requests: Sequence[Request]) -> list[_Take]:
    """The takes at their start; each piece of furniture is looked at once."""
    surfaces: dict[int, np.ndarray] = {}
    takes = []
    for request in requests:
        points = None
        if request.action in ("sit", "lie") and request.object_triangles is not None:
            key = id(request.object_triangles)
            if key not in surfaces:
                surfaces[key] = sample_surface(request.object_triangles, SURFACE_SAMPLES, seed=0)[0]
            points = surfaces[key]
        takes.append(_take(request, points))
    return takes


def _take(request: Request, points: np.ndarray | None) -> _Take:
    """The take at its start; a deep seat's goal is first set forward, see seat_edge.py. points: (N, 3) on the surface
    of the piece that it is about."""
    goal, front, top = request.goal, None, None
    if points is not None:
        floor = request.waypoints[-1][1] if len(request.waypoints) else request.start_position[1]
        top = RestingTop.of(points, goal, floor)
        if request.action == "sit":
            front = SeatFront.of(points, goal, floor)
            goal = replace(goal, position=goal.position + front.stand_off * np.asarray(goal.direction))
    route = Route(request.start_position, request.waypoints, goal, request.action)
    return _Take(request, route, front=front, top=top)


def _rollout(takes: list[_Take], network: tuple) -> Rollout:
    """The Rollout at its start: poses, places and objects of all takes."""
    import torch

    from .rollout import Rollout
    from .start import Start

    net, heights, poses = network
    starts = []
    for take in takes:
        request = take.request
        if request.after is not None:
            starts.append(Start.after(request.after, float(take.route.points[0][1])))
            continue
        pick = request.seed % len(heights)
        root = np.array([*request.start_position[[0, 2]], request.start_yaw])
        starts.append(Start.standing(float(heights[pick]), poses[pick].double().numpy(), root))
    centres, occupancy = _objects(takes)
    tensor = lambda values: torch.as_tensor(np.asarray(values), dtype=torch.float32)
    return Rollout(
        net, starts, tensor(centres), tensor(occupancy),
        [take.request.seed for take in takes], tensor([[take.request.style] for take in takes]),
    )  # fmt: skip


def _objects(takes: list[_Take]) -> tuple[np.ndarray, np.ndarray]:
    """Cell centres (B, 512, 3), over a floor at height 0, and occupancy (B, 512); zero where there is no object."""
    centres, occupancy = np.zeros((len(takes), 512, 3)), np.zeros((len(takes), 512))
    grids: dict[tuple[int, float], InteractionGrid] = {}
    for k, take in enumerate(takes):
        request = take.request
        if request.object_triangles is None or request.action not in ("sit", "lie"):
            continue
        key = id(request.object_triangles), request.object_yaw
        if key not in grids:
            grids[key] = InteractionGrid.build(request.object_triangles, request.object_yaw)
        moved = (take.front.stand_off if take.front else 0.0) * np.asarray(request.goal.direction)
        centres[k] = grids[key].centres + moved - np.array([0.0, take.route.points[-1][1], 0.0])
        occupancy[k] = grids[key].occupancy
    return centres, occupancy


def _share_done(takes: list[_Take], frame: int, limit: int) -> float:
    ways = [
        min(take.travelled / max(take.route.length, 0.1), 1.0) * 0.7 + 0.3 * (take.held > 0) for take in takes
    ]
    return float(max(min(ways) * 0.95, frame / limit))


def _update(takes: list[_Take], recorded: dict[str, list[np.ndarray]], frame: int) -> None:
    pelvis, roots, weights = recorded["pelvis"][-1], recorded["roots"][-1], recorded["actions"][-1]
    upright = recorded["matrices"][-1][:, CHEST, 1, 1]
    back = recorded["pelvis"][max(0, len(recorded["pelvis"]) - 6)]
    span = max(min(len(recorded["pelvis"]) - 1, 5), 1) / FPS
    for k, take in enumerate(takes):
        speed = float(np.linalg.norm(pelvis[k] - back[k])) / span
        sinking = float(abs(pelvis[k, 1] - back[k, 1])) / span
        take.update(roots[k, :2], pelvis[k], speed, sinking, weights[k], upright[k], frame)


def _finished(take: _Take, arrays: dict[str, np.ndarray]) -> Motion | SampError:
    """The take as a Motion with feet locked and its end on the goal, or why there is none."""
    if take.done_at is None:
        left = np.linalg.norm((arrays["pelvis"][-1] - np.asarray(take.request.goal.position))[[0, 2]])
        return RolloutError(
            f"The character got stuck {left:.1f} m from the goal; try another seed, another goal or another start."
        )
    end = take.done_at + 1
    quats = rotation.matrix_to_quaternion(arrays["matrices"][:end].astype(np.float64))
    local = rotation.continuous(skeleton.local_rotations(quats))
    motion = Motion(
        root=arrays["pelvis"][:end].astype(np.float64),
        rotations=local,
        contacts=arrays["contacts"][:end].astype(np.float64),
        actions=arrays["actions"][:end].astype(np.float64),
    )
    return finish.finish(motion, take.route, take.request.action, take.front, take.top)
