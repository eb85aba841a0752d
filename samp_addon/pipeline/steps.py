"""Several actions in a row as one take: each step goes on where the one before it ended.

Sit, stand up, walk to the window: every step has a goal, a way and a rollout of its own, and begins with the pose and
the velocities of the last one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .. import rotation
from ..easing import smoothstep
from ..methods.take import Failure, Situation, Take, Tools
from ..motion import Motion
from ..progress import Progress, SubProgress
from .chain import networks, synthesise
from .job import Job

FADE = 12  # frames in which what does not fit at a joint dies away


def synthesise_steps(
    steps: Sequence[tuple[Job, Situation]],
    progress: Progress = lambda stage, share: None,
    tools: Tools | None = None,
) -> tuple[list[Take], list[Failure]]:
    """Takes that do all the steps, one for each seed of the first job, and why others failed.

    The jobs after the first have its seeds. A take's goal and interaction are the last step's; its ``steps`` are the
    single ones. Raises SampError where no take can be made at all.
    """
    if len(steps) == 1:
        return synthesise(*steps[0], progress, tools)
    tools = tools or networks()
    done: dict[int, list[Take]] = {}
    failures: list[Failure] = []
    for number, (job, situation) in enumerate(steps):
        part = SubProgress(progress, number / len(steps), 1 / len(steps))
        after = {seed: takes[-1] for seed, takes in done.items()} if number else None
        takes, failed = synthesise(job, situation, part, tools, after)
        failures += [replace(f, message=f"Step {number + 1}: {f.message}") for f in failed]
        done = {take.seed: [*done.get(take.seed, []), take] for take in takes}
        if not done:
            break
    return [joined(takes) for takes in done.values()], failures


def joined(takes: Sequence[Take]) -> Take:
    """One take out of the steps of one seed."""
    motion = takes[0].motion
    for take in takes[1:]:
        motion = _append(motion, take.motion)
    seconds: dict[str, float] = {}
    for take in takes:
        for stage, value in take.seconds.items():
            seconds[stage] = seconds.get(stage, 0.0) + value
    return replace(
        takes[-1],
        motion=motion,
        waypoints=np.concatenate([take.waypoints for take in takes]),
        seconds=seconds,
        attempts=max(take.attempts for take in takes),
        steps=tuple(takes),
    )


def _append(first: Motion, second: Motion) -> Motion:
    """Both motions, the second one's difference at the joint fading out."""
    weight = smoothstep(1 - np.arange(len(second)) / FADE)
    ahead = 2 * first.root[-1] - first.root[-2] if len(first) > 1 else first.root[-1]
    root = second.root + weight[:, None] * (ahead - second.root[0])
    offset = rotation.multiply(first.rotations[-1], rotation.conjugate(second.rotations[0]))
    still = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), second.rotations.shape)
    fading = rotation.slerp(still, np.broadcast_to(offset, second.rotations.shape), weight[:, None])
    rotations = np.concatenate([first.rotations, rotation.multiply(fading, second.rotations)])
    both = lambda a, b: None if a is None or b is None else np.concatenate([a, b])
    begun = second.interaction_start
    return replace(
        first,
        root=np.concatenate([first.root, root]),
        rotations=rotation.continuous(rotations),
        contacts=both(first.contacts, second.contacts),
        actions=both(first.actions, second.actions),
        interaction_start=None if begun is None else begun + len(first),
    )
