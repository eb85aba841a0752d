"""SAMP (papers/samp.txt): from requests to finished takes, by the rollout of MotionNet as one batch."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .... import rotation, skeleton
from ....errors import RolloutError, SampError
from ....motion import Motion
from ....progress import show
from ....torch_threads import single_thread
from ....vocabulary import ACTIONS
from ..finishing import finish
from ..load_networks import MotionNetwork, load_motion_net
from ..request import Request
from .planned_take import PlannedTake, plan_takes, start_rollout
from .record import Record
from .tracking import RolloutProgress

if TYPE_CHECKING:
    from .rollout import Frame

NETWORK, GUIDED, FINISHED = STAGES = ("network", "guided", "finished")
"""The raw rollout; with path following; and also brought onto its goal, with locked feet (finishing/)."""

MULTITHREADED = 4  # takes from which a batch gains from several threads of torch


def generate(
    requests: Sequence[Request],
    progress: Callable[[float], None] = lambda share: None,
    network: MotionNetwork | None = None,
    stage: str = FINISHED,
    without: Collection[str] = (),
) -> list[Motion | SampError]:
    """Generate one take for each request, all as one batch. Return the Motion, or the error that prevented it.

    progress: called with the share done, from 0 to 1, and shown the first take as it grows (progress.py); an exception
    that it raises stops the work. network: as returned by load_motion_net; the shipped one if omitted. stage: one of
    STAGES; the earlier ones, for evaluation, also return takes that got stuck. without: finish.CORRECTIONS left out.
    """
    results: list[Motion | SampError] = [_refusal(request) for request in requests]
    valid = [k for k, refusal in enumerate(results) if refusal is None]
    for k, result in zip(
        valid,
        _run([requests[k] for k in valid], progress, network or load_motion_net(), stage, without)
        if valid
        else [],
        strict=True,
    ):
        results[k] = result
    return results


def _refusal(request: Request) -> SampError | None:
    """Return why a request cannot be fulfilled at all, or None."""
    if request.action not in ACTIONS:
        return SampError(f"There is no action '{request.action}'; choose one of {', '.join(ACTIONS)}.")
    return None


def _run(
    requests: Sequence[Request],
    progress: Callable[[float], None],
    network: MotionNetwork,
    stage: str,
    without: Collection[str],
) -> list[Motion | SampError]:
    """Roll out the batch, frame by frame, until every take is done or stuck."""
    import torch

    from .steering import Guide, plan

    takes = plan_takes(requests, network.net)
    record, done, frame = Record(len(takes)), np.zeros(len(takes), bool), 0
    routes, postures = [take.route for take in takes], [take.posture for take in takes]
    tracked = RolloutProgress(requests, routes, postures)
    going, limit = np.arange(len(takes)), int(tracked.limit.max())
    with torch.inference_mode(), single_thread(len(takes) < MULTITHREADED):
        run, guide = start_rollout(takes, network), Guide(tracked)
        # Rollouts of the training begin with the planned path, too. Without it the network alone stands for seconds.
        run.set_path(plan(tracked, run.roots.numpy().astype(np.float64)))
        while len(going):
            run.set_goals(torch.as_tensor(tracked.goals(), dtype=torch.float32))
            new = run.step(None if stage == NETWORK else guide)
            record.add(new, tracked.travelled, going)
            tracked.update(record.observe(going), frame)
            if frame % 5 == 0:
                progress(max(0.95 * tracked.share(), frame / limit))
                show(progress, _preview(takes[going[0]], new))
            ended = tracked.ended(frame)
            if ended.any():
                done[going] = tracked.done_at >= 0
                rows = np.flatnonzero(~ended)
                going, tracked, run = going[rows], tracked.select(rows), run.select(torch.as_tensor(rows))
                guide = guide.select(rows, tracked)
            frame += 1
    if stage != FINISHED:
        return [_raw(take, record.of(k)) for k, take in enumerate(takes)]
    return [_finished(take, record.of(k), done[k], without) for k, take in enumerate(takes)]


def _preview(take: PlannedTake, frame: Frame) -> Motion:
    """Return the newest frame of the first take in progress, at the height of its floor."""
    matrices = frame.matrices[0].double().numpy()
    local = skeleton.local_rotations(rotation.matrix_to_quaternion(matrices)[None])
    root = frame.pelvis[0].double().numpy() + [0.0, take.route.points[0][1], 0.0]
    return Motion(root[None], local)


def _raw(take: PlannedTake, recorded: dict[str, np.ndarray]) -> Motion:
    """Return the Motion of a rollout as it is, at the heights of its floor."""
    motion = _motion(recorded)
    heights = take.route.heights(motion.root[:, [0, 2]], recorded["travelled"])
    start = finish.interaction_start(motion, take.request.action)
    raised = motion.root + heights[:, None] * np.array([0.0, 1.0, 0.0])
    return replace(motion, root=raised, interaction_start=start)


def _motion(recorded: dict[str, np.ndarray]) -> Motion:
    """Return the Motion of a record, see Record.of, on a floor at height 0."""
    local = skeleton.local_rotations(rotation.matrix_to_quaternion(recorded["matrices"]))
    return Motion(
        root=recorded["pelvis"],
        rotations=rotation.continuous(local),
        contacts=recorded["contacts"],
        actions=recorded["actions"],
    )


def _finished(
    take: PlannedTake, recorded: dict[str, np.ndarray], done: bool, without: Collection[str]
) -> Motion | SampError:
    """Return the finished Motion of a take, or why there is none. recorded: see Record.of."""
    if not done:
        left = np.linalg.norm((recorded["pelvis"][-1] - np.asarray(take.request.goal.position))[[0, 2]])
        return RolloutError(
            f"The character got stuck {left:.1f} m from the goal; try another seed, another goal or another start."
        )
    motion = _motion(recorded)
    request = take.request
    return finish.finish(
        motion,
        take.route,
        recorded["travelled"],
        request.action,
        take.front,
        take.top,
        take.back,
        take.table,
        take.posture,
        request.ground,
        request.free,
        take.unfolded,
        without,
    )
