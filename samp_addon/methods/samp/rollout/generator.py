"""SAMP (papers/samp.txt): from a request to finished takes by the rollout of MotionNet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .... import rotation, skeleton
from ....errors import RolloutError, SampError
from ....motion import ACTIONS, Motion
from ....progress import show
from ....scene.geometry import sample_surface
from ....scene.voxels import InteractionGrid
from ....torch_threads import single_thread
from ..finishing import finish
from ..finishing.resting import RestingTop
from ..finishing.seat_edge import SeatFront
from ..load_networks import MotionNetwork, load_motion_net
from ..request import Request
from ..route import Route
from .tracking import FPS, Seen, UnderWay

if TYPE_CHECKING:
    from .rollout import Frame, Rollout

LOOK_BACK = 5  # frames over which a pelvis' speed is measured
WORTH_THREADS = 4  # takes from which torch's threads gain something
SURFACE_SAMPLES = 60_000  # of a piece that is sat or lain on
CHEST = skeleton.INDEX["spine3"]
RECORDED = ("pelvis", "matrices", "contacts", "actions", "roots", "travelled")


def generate(
    requests: Sequence[Request],
    progress: Callable[[float], None] = lambda share: None,
    network: MotionNetwork | None = None,
) -> list[Motion | SampError]:
    """One take for each request, all rolled out as one batch: the Motion, or the error that says what went wrong.

    progress is called with the share done, from 0 to 1, and shown the first take as it comes, see progress.py; what
    it raises stops the work. network: as load_motion_net gives it; left out, the shipped one.
    """
    results: list[Motion | SampError] = [_refusal(request) for request in requests]
    sound = [k for k, refusal in enumerate(results) if refusal is None]
    for k, result in zip(
        sound,
        _run([requests[k] for k in sound], progress, network or load_motion_net()) if sound else [],
        strict=True,
    ):
        results[k] = result
    return results


def _refusal(request: Request) -> SampError | None:
    """Why a request cannot be fulfilled at all, or None."""
    if request.action not in ACTIONS:
        return SampError(f"There is no action '{request.action}'; choose one of {', '.join(ACTIONS)}.")
    return None


@dataclass(frozen=True)
class _Take:
    """What is decided for one take before it starts."""

    request: Request
    route: Route
    front: SeatFront | None = None
    top: RestingTop | None = None


class _Record:
    """What the takes showed, frame by frame: for each name of RECORDED (T, B, ...)."""

    def __init__(self, takes: int) -> None:
        self.length, self.lengths = 0, np.zeros(takes, int)
        self.values: dict[str, np.ndarray] = {}

    def add(self, frame: Frame, travelled: np.ndarray, going: np.ndarray) -> None:
        """Notes a frame of the takes with these numbers, and how far they had come on their ways before it."""
        for name in RECORDED:
            new = travelled if name == "travelled" else getattr(frame, name).numpy()
            kept = self.values.get(name, np.empty((0, len(self.lengths), *new.shape[1:]), np.float32))
            if self.length == len(kept):
                kept = np.concatenate([kept, np.zeros((max(len(kept), 256), *kept.shape[1:]), np.float32)])
            kept[self.length, going] = new
            self.values[name] = kept
        self.length += 1
        self.lengths[going] = self.length

    def newest(self, name: str, going: np.ndarray, back: int = 0) -> np.ndarray:
        """What was noted of some takes so many frames ago, or in the first frame."""
        return self.values[name][max(0, self.length - 1 - back), going]

    def of(self, take: int) -> dict[str, np.ndarray]:
        """All of one take."""
        return {
            name: kept[: self.lengths[take], take].astype(np.float64) for name, kept in self.values.items()
        }


def _run(
    requests: Sequence[Request], progress: Callable[[float], None], network: MotionNetwork
) -> list[Motion | SampError]:
    """The batch, frame by frame, until every take is done or has used up its time."""
    import torch

    from .steering import Guide

    takes = _takes(requests)
    record, done, frame = _Record(len(takes)), np.zeros(len(takes), bool), 0
    way = UnderWay(requests, [take.route for take in takes])
    going, limit = np.arange(len(takes)), int(way.limit.max())
    with torch.inference_mode(), single_thread(len(takes) < WORTH_THREADS):
        run, guide = _rollout(takes, network), Guide(way)
        while len(going):
            run.set_goals(torch.as_tensor(way.goals(), dtype=torch.float32))
            new = run.step(guide)
            record.add(new, way.travelled, going)
            way.update(_seen(record, going), frame)
            if frame % 5 == 0:
                progress(max(0.95 * way.share(), frame / limit))
                show(progress, _glimpse(takes[going[0]], new))
            over = way.over(frame)
            if over.any():
                done[going] = way.done_at >= 0
                rows = np.flatnonzero(~over)
                going, way, run = going[rows], way.only(rows), run.only(torch.as_tensor(rows))
                guide = guide.only(rows, way)
            frame += 1
    return [_finished(take, record.of(k), done[k]) for k, take in enumerate(takes)]


def _seen(record: _Record, going: np.ndarray) -> Seen:
    """What the newest frame shows of the takes that are still going."""
    pelvis, back = record.newest("pelvis", going), record.newest("pelvis", going, LOOK_BACK)
    span = max(min(record.length - 1, LOOK_BACK), 1) / FPS
    return Seen(
        roots=record.newest("roots", going)[:, :2],
        pelvis=pelvis,
        speed=np.linalg.norm(pelvis - back, axis=-1) / span,
        sinking=np.abs(pelvis[:, 1] - back[:, 1]) / span,
        weights=record.newest("actions", going),
        upright=record.newest("matrices", going)[:, CHEST, 1, 1],
    )


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


def _rollout(takes: list[_Take], network: MotionNetwork) -> Rollout:
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


def _finished(take: _Take, told: dict[str, np.ndarray], done: bool) -> Motion | SampError:
    """The take as a Motion with feet locked and its end on the goal, or why there is none. told: what was recorded of
    it, see _Record.of."""
    if not done:
        left = np.linalg.norm((told["pelvis"][-1] - np.asarray(take.request.goal.position))[[0, 2]])
        return RolloutError(
            f"The character got stuck {left:.1f} m from the goal; try another seed, another goal or another start."
        )
    local = skeleton.local_rotations(rotation.matrix_to_quaternion(told["matrices"]))
    motion = Motion(
        root=told["pelvis"],
        rotations=rotation.continuous(local),
        contacts=told["contacts"],
        actions=told["actions"],
    )
    return finish.finish(motion, take.route, told["travelled"], take.request.action, take.front, take.top)
