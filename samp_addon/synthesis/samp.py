"""SAMP (papers/samp.txt): from a request to finished takes by the rollout of MotionNet."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from .. import rotation, skeleton
from ..errors import RolloutError, SampError
from ..motion import ACTIONS, Motion
from ..scene.voxels import InteractionGrid
from . import finish
from .request import Request
from .route import REACHED, STOPPING, Route

ATTEMPTS = 3  # with fresh noise, before a take that gets stuck is given up
ARRIVED = 0.2  # metres from the goal
STILL = 0.1  # m/s
SLOWEST = 0.45  # m/s that a character may average on its way before the take counts as stuck
GRACE = 10.0  # seconds on top, for turning, sitting down and settling
_SEED_STRIDE = 1_000_003


@functools.cache
def load_network() -> tuple:
    """MotionNet in evaluation mode and its start poses: heights (K,) and local quaternions (K, 22, 4)."""
    import torch

    from ...models import weights
    from ...models.motion_net import MotionNet

    try:
        tensors = weights.load_weights("motion_net")
    except weights.WeightsError as error:
        raise SampError(str(error)) from error
    starts = tensors.pop("start_heights"), tensors.pop("start_rotations")
    net = MotionNet()
    # The encoder is needed for training only and is not shipped.
    net.load_state_dict({k: v.float() for k, v in tensors.items()}, strict=False)
    net.eval()
    torch.set_grad_enabled(True)
    return net, starts[0].float(), starts[1].float()


def generate(request: Request) -> list[Motion | RolloutError]:
    """One take for each seed, in order: the Motion, or the RolloutError that says how far it came.

    The same seed gives the same take, whatever other seeds run beside it. Raises SampError for a request that no
    seed could fulfil, and whatever request.progress raises.
    """
    if request.action not in ACTIONS:
        raise SampError(f"There is no action '{request.action}'; choose one of {', '.join(ACTIONS)}.")
    if request.action == "lie":
        raise SampError("Lying down is not learnt yet in this version; choose sit, walk, run or idle.")
    results: list[Motion | RolloutError] = [RolloutError("The take was not started.")] * len(request.seeds)
    open_takes = list(range(len(request.seeds)))
    for attempt in range(ATTEMPTS):
        seeds = [request.seeds[k] + attempt * _SEED_STRIDE for k in open_takes]
        for k, result in zip(open_takes, _run(request, seeds), strict=True):
            results[k] = result
        open_takes = [k for k in open_takes if isinstance(results[k], RolloutError)]
        if not open_takes:
            break
    return results


@dataclass
class _Take:
    """What is decided for one take while it runs."""

    route: Route
    number: int = 0  # of the goal in force
    travelled: float = 0.0
    held: int = 0
    done_at: int | None = None

    def goal(self) -> np.ndarray:
        return self.route.goals[self.number]

    def update(self, root: np.ndarray, pelvis: np.ndarray, speed: float, weights: np.ndarray, hold: int, frame: int):
        """Passes way-points, and counts the frames in which the action is being held at the goal."""
        self.travelled = self.route.project(root, self.travelled)
        last = len(self.route.goals) - 1
        while self.number < last:
            goal = self.goal()
            passed = self.travelled > self.route.lengths[self.number + 1] + 0.05
            if np.hypot(*(root - goal[[0, 2]])) > REACHED and not passed:
                break
            self.number += 1
        goal = self.goal()
        action = int(np.argmax(goal[6:]))
        near = np.hypot(pelvis[0] - goal[0], pelvis[2] - goal[2]) < (2 * ARRIVED if action == 0 else 1.5 * ARRIVED)
        settled = self.number == last and near and weights[action] > 0.6 and speed < STILL
        self.held += int(settled)
        if self.held >= hold and self.done_at is None:
            self.done_at = frame


def _run(request: Request, seeds: list[int]) -> list[Motion | RolloutError]:
    """One attempt for these seeds, as one batch."""
    import torch

    from ...models import state
    from .rollout import Rollout

    net, heights, poses = load_network()
    floor = float(request.start_position[1])
    route = Route(request.start_position, request.waypoints, request.goal, request.action)
    grid = None
    if request.object_triangles is not None and request.action in ("sit", "lie"):
        grid = InteractionGrid.build(request.object_triangles, request.object_yaw)
    base = route.points[-1][1]
    centres = occupancy = None
    if grid is not None:
        centres = torch.as_tensor(grid.centres - np.array([0.0, base, 0.0]), dtype=torch.float32)
        occupancy = torch.as_tensor(grid.occupancy, dtype=torch.float32)
    pick = torch.tensor([seed % len(heights) for seed in seeds])
    matrices = torch.as_tensor(rotation.quaternion_to_matrix(poses.numpy()), dtype=torch.float32)[pick]
    start = torch.tensor([request.start_position[0], request.start_position[2], request.start_yaw]).float()
    takes = [_Take(route) for _ in seeds]
    hold = max(1, round(request.hold_seconds * state.FPS))
    limit = round((route.length / SLOWEST + GRACE + request.hold_seconds) * state.FPS)
    recorded: dict[str, list[np.ndarray]] = {"pelvis": [], "matrices": [], "contacts": [], "actions": [], "roots": []}
    with torch.inference_mode():
        run = Rollout(net, heights[pick], matrices, start.repeat(len(seeds), 1), centres, occupancy, seeds, request.style)
        guide = functools.partial(_follow, takes)
        for frame in range(limit):
            run.set_goals(torch.as_tensor(np.stack([take.goal() for take in takes]), dtype=torch.float32))
            new = run.step(guide)
            for name, values in recorded.items():
                values.append(getattr(new, name).numpy().copy())
            _update(takes, recorded, hold, frame)
            if request.progress is not None and frame % 5 == 0:
                request.progress(_share_done(takes, frame, limit))
            if all(take.done_at is not None for take in takes):
                break
    arrays = {name: np.stack(values) for name, values in recorded.items()}
    return [_finished(request, take, {n: a[:, k] for n, a in arrays.items()}, floor) for k, take in enumerate(takes)]


def _share_done(takes: list[_Take], frame: int, limit: int) -> float:
    ways = [min(take.travelled / max(take.route.length, 0.1), 1.0) * 0.7 + 0.3 * (take.held > 0) for take in takes]
    return float(max(min(ways) * 0.95, frame / limit))


def _update(takes: list[_Take], recorded: dict[str, list[np.ndarray]], hold: int, frame: int) -> None:
    pelvis, roots, weights = recorded["pelvis"][-1], recorded["roots"][-1], recorded["actions"][-1]
    back = recorded["pelvis"][max(0, len(recorded["pelvis"]) - 6)]
    span = max(min(len(recorded["pelvis"]) - 1, 5), 1) / 30
    for k, take in enumerate(takes):
        speed = float(np.linalg.norm(pelvis[k] - back[k])) / span
        take.update(roots[k, :2], pelvis[k], speed, weights[k], hold, frame)


def _follow(takes: list[_Take], future, roots):
    """Bends the predicted future path (B, 6, 3) onto the route, far ahead more than near; keeps its speed."""
    import torch

    from .rollout import FOLLOW, FUTURE

    path = future.numpy().astype(np.float64).copy()
    now = roots.numpy().astype(np.float64)
    share = FOLLOW * (np.arange(1, FUTURE + 1) / FUTURE)
    for k, take in enumerate(takes):
        left = take.route.length - take.travelled
        last = take.number == len(take.route.goals) - 1
        if last and left < STOPPING:
            continue  # the last metre belongs to the network and the goal's frame
        steps = np.diff(np.concatenate([now[k : k + 1, :2], path[k, :, :2]]), axis=0)
        ahead = take.travelled + np.cumsum(np.linalg.norm(steps, axis=-1))
        wanted = take.route.at(ahead)
        way = take.route.at(ahead + 0.2) - take.route.at(ahead - 0.05)
        facing = np.arctan2(way[:, 0], way[:, 1])
        turn = np.remainder(facing - path[k, :, 2] + np.pi, 2 * np.pi) - np.pi
        path[k, :, :2] += share[:, None] * (wanted - path[k, :, :2])
        path[k, :, 2] += share * turn
    return torch.as_tensor(path, dtype=torch.float32)


def _finished(request: Request, take: _Take, arrays: dict[str, np.ndarray], floor: float) -> Motion | RolloutError:
    """The take as a Motion with feet locked and its end on the goal, or why there is none."""
    if take.done_at is None:
        left = np.linalg.norm((arrays["pelvis"][-1] - np.asarray(request.goal.position))[[0, 2]])
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
    return finish.finish(motion, take.route, request)
