"""Takes before their rollout: the route of each, its start pose, and the object that it is about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .... import frames
from ....scene.geometry import sample_surface
from ....scene.voxels import InteractionGrid
from ....vocabulary import ACTIONS, POSTURE_NAMES, SEATED
from .. import postures
from ..finishing import leaning
from ..finishing.leaning import SeatBack
from ..finishing.resting import RestingTop
from ..finishing.seat_edge import SeatFront
from ..request import Request
from ..route import Route
from ..unfolding import Unfolded

if TYPE_CHECKING:
    from .....models.motion_net import MotionNet
    from ..load_networks import MotionNetwork
    from .rollout import Rollout

SURFACE_SAMPLES = 60_000  # points on an object that is sat or lain on


@dataclass(frozen=True)
class PlannedTake:
    """A take before its rollout.

    posture: of the rest, as asked for or drawn. front, top: of its object, or None where it has none. back: of a seat,
    if the body leans on it. table: places (2, 3) of the left and the right wrist on a table, over the floor. unfolded:
    the path over stairs, on which the route lies; None without stairs.
    """

    request: Request
    route: Route
    posture: tuple[str, ...] = ()
    front: SeatFront | None = None
    top: RestingTop | None = None
    back: SeatBack | None = None
    table: np.ndarray | None = None
    unfolded: Unfolded | None = None

    @property
    def moved(self) -> np.ndarray:
        """Metres (3,) by which the start is moved, so that the route is as long as the rollout needs it."""
        return np.zeros(3) if self.unfolded is None else self.unfolded.moved[0]


def plan_takes(requests: Sequence[Request], net: MotionNet) -> list[PlannedTake]:
    """Plan one take of a network for each request; the surface of each object is sampled once."""
    surfaces: dict[int, np.ndarray] = {}
    takes = []
    for request in requests:
        points = None
        if request.action in SEATED and request.object_triangles is not None:
            key = id(request.object_triangles)
            if key not in surfaces:
                surfaces[key] = sample_surface(request.object_triangles, SURFACE_SAMPLES, seed=0)[0]
            points = surfaces[key]
        takes.append(_plan(request, points, net))
    return takes


def start_rollout(takes: Sequence[PlannedTake], network: MotionNetwork) -> Rollout:
    """Return the rollout of the takes at their starts."""
    import torch

    from .rollout import Rollout
    from .start import Start

    net, heights, poses = network
    starts = []
    for take in takes:
        request = take.request
        if request.after is not None:
            after = replace(request.after, root=request.after.root + take.moved)
            starts.append(Start.after(after, float(take.route.points[0][1])))
            continue
        pick = request.seed % len(heights)
        root = np.array([*(request.start_position + take.moved)[[0, 2]], request.start_yaw])
        starts.append(Start.standing(float(heights[pick]), poses[pick].double().numpy(), root))
    centres, occupancy = _objects(takes, bool(net.goal_grid))
    tensor = lambda values: torch.as_tensor(np.asarray(values), dtype=torch.float32)
    return Rollout(
        net, starts, tensor(centres), tensor(occupancy),
        [_latent_seed(take.request) for take in takes], tensor([[take.request.style] for take in takes]),
        torch.as_tensor([ACTIONS.index(take.request.action) for take in takes]),
        tensor([postures.numbers(take.posture) for take in takes]),
    )  # fmt: skip


def _latent_seed(request: Request) -> int:
    return request.seed if request.latent_seed is None else request.latent_seed


def _posture(request: Request, net: MotionNet) -> tuple[str, ...]:
    """Return the posture of the rest: the artist's, with what it leaves open drawn as in the training data."""
    if not net.postures or request.action not in SEATED:
        return request.posture
    shares = [
        (tuple(name for name, is_so in zip(POSTURE_NAMES, row, strict=True) if is_so), share)
        for row, share in zip(net.posture_rows.tolist(), net.posture_shares.tolist(), strict=True)
    ]
    return postures.drawn(shares, request.action, request.posture_places(), request.seed, request.posture)


def _plan(request: Request, points: np.ndarray | None, net: MotionNet) -> PlannedTake:
    """Plan one take. points: (N, 3) on the surface of its object, or None."""
    goal, front, top, back, table = request.goal, None, None, None, None
    posture = _posture(request, net)
    if points is not None:
        floor = request.waypoints[-1][1] if len(request.waypoints) else request.start_position[1]
        top = RestingTop.of(points, goal, floor)
        if request.action == "sit":
            front = SeatFront.of(points, goal, floor)
            if "hands_on_table" not in posture:
                most = leaning.MOST if "lean_back" in posture else leaning.UPRIGHT_MOST
                back = SeatBack.of(points, goal, most)
            elif (wrists := request.table()) is not None:
                table = wrists - [0.0, floor, 0.0]
    unfolded = Unfolded.of(request.waypoints, request.flights) if len(request.flights) else None
    if unfolded is None:
        route = Route(request.start_position, request.waypoints, goal, request.action)
    else:
        start = request.start_position + unfolded.moved[0]
        route = Route(start, unfolded.points, goal, request.action)
    return PlannedTake(request, route, posture, front, top, back, table, unfolded)


def _objects(takes: Sequence[PlannedTake], goal_grid: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the cell centres (B, 512, 3) over a floor at height 0, and the occupancy (B, 512), of the objects.

    Both are zero where a take has no object. goal_grid: whether the grids are drawn around the goals.
    """
    centres, occupancy = np.zeros((len(takes), 512, 3)), np.zeros((len(takes), 512))
    grids: dict[tuple[int, float], InteractionGrid] = {}
    for k, take in enumerate(takes):
        request = take.request
        if request.object_triangles is None or request.action not in SEATED:
            continue
        floor = float(take.route.points[-1][1])
        if goal_grid:
            yaw = float(frames.direction_yaw(np.asarray(request.goal.direction)))
            grid = InteractionGrid.around(request.object_triangles, request.goal.position, yaw, floor)
        else:
            front = request.object_front()
            key = id(request.object_triangles), front
            if key not in grids:
                grids[key] = InteractionGrid.build(request.object_triangles, front)
            grid = grids[key]
        centres[k] = grid.centres - np.array([0.0, floor, 0.0])
        occupancy[k] = grid.occupancy
    return centres, occupancy
