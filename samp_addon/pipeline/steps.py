"""Several actions in a row as one take: each step begins where the one before it ended.

Sit, stand up, walk to the window: every step has a goal, a path and a motion of its own, by any method, and begins
with the pose and the velocities in which the last one ended.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .. import rotation
from ..body import human
from ..clock import Clock
from ..methods.appending import append, faded
from ..methods.method import Method
from ..methods.scene_view import SceneView
from ..methods.step import Step
from ..methods.take import Failure, Take
from ..motion import Motion
from ..progress import Progress, SubProgress
from . import attempts, other_body


def generate(
    steps: Sequence[tuple[Method, Step, SceneView]], seeds: Sequence[int], progress: Progress
) -> tuple[list[Take], list[Failure]]:
    """Return takes that do all the steps, one for each seed, and why the other seeds have none.

    A take's goal and interaction are the last step's; its `steps` are the single ones.
    """
    if len(steps) == 1:
        return attempts.generate(*steps[0], seeds, progress)
    done: dict[int, list[Take]] = {seed: [] for seed in seeds}
    failures: list[Failure] = []
    for number, (method, step, scene) in enumerate(steps):
        part = SubProgress(progress, number / len(steps), 1 / len(steps))
        after = {seed: takes[-1] for seed, takes in done.items() if takes}
        view = replace(scene, after=after or scene.after)
        takes, failed = attempts.generate(method, step, view, list(done), part)
        failures += [replace(f, message=f"Step {number + 1}: {f.message}") for f in failed]
        # A method makes bodies of proportions that it knows; steps go on in the default ones.
        takes = [other_body.fitted(take, human.load()) for take in takes]
        done = {take.seed: [*done[take.seed], take] for take in takes}
        if not done:
            break
    return [joined(takes) for takes in done.values()], failures


def joined(takes: Sequence[Take]) -> Take:
    """Return one take made of the steps of one seed."""
    motion, clock = takes[0].motion, Clock()
    for take in takes[1:]:
        motion = append(motion, take.motion)
    for take in takes:
        clock.add(take.seconds)
    paths = [take.waypoints for take in takes if take.waypoints is not None]
    starts = np.cumsum([0, *(len(take.motion) for take in takes)])
    sub_goals = [
        replace(place, frame=place.frame + int(start))
        for take, start in zip(takes, starts, strict=False)
        for place in take.sub_goals or ()
    ]
    return replace(
        takes[-1],
        motion=motion,
        waypoints=np.concatenate(paths) if paths else None,
        sub_goals=tuple(sub_goals) or None,
        seconds=clock.seconds,
        attempts=max(take.attempts for take in takes),
        steps=tuple(takes),
        remarks=tuple(
            f"Step {number}: {remark}"
            for number, take in enumerate(takes, start=1)
            for remark in take.remarks
        ),
    )


def from_pose(take: Take, pose: Motion) -> Take:
    """Return the take with a pose (one frame, same rest joints) as its beginning, from which it is blended."""
    motion = take.motion
    rotations = motion.rotations.copy()
    count = min(rotations.shape[1], pose.rotations.shape[1])
    root, rotations[:, :count] = faded(
        replace(motion, rotations=motion.rotations[:, :count]), pose.root[0], pose.rotations[0, :count]
    )
    return replace(take, motion=replace(motion, root=root, rotations=rotation.continuous(rotations)))
