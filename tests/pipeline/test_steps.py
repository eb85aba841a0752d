"""Several actions in a row as one take; the networks are stood in for."""

from dataclasses import replace

import fakes
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.evaluation import metrics
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.pipeline.job import Job
from views import takes_of, view_of

JOB = Job(action="sit", target="Sofa", hold=1.5, seed=5, variants=2)


@pytest.fixture(scope="module")
def room():
    return rooms.random_room(1, rooms.sofa)


@pytest.fixture(scope="module")
def steps(room):
    """Sit on the sofa, walk back to the start, sit down again."""
    then = (Step(action="walk", to=(0.0, 0.0, 0.0)), Step(action="sit", target="Sofa"))
    back = view_of(room, target=None, parts=(), destination=(room.start, None))
    return [replace(JOB, then=then), view_of(room), back, view_of(room)]


@pytest.fixture(scope="module")
def takes(steps):
    made, failures = takes_of(*steps)
    assert not failures
    return made


def test_one_take_does_all_the_steps(takes, room):
    assert [take.seed for take in takes] == [5, 6]
    for take in takes:
        assert [step.goal.action for step in take.steps] == ["sit", "walk", "sit"]
        assert len(take.motion) == sum(len(step.motion) for step in take.steps)
        assert metrics.success(take.motion, take.goal)
        ends = np.cumsum([len(step.motion) for step in take.steps]) - 1
        away = take.motion.root[ends[1]] - room.start
        assert np.hypot(away[0], away[2]) < 0.1
        assert take.motion.interaction_start > ends[1]


def test_nothing_jumps_where_steps_meet(takes):
    for take in takes:
        assert np.linalg.norm(np.diff(take.motion.root, axis=0), axis=-1).max() < 0.2
        turns = np.abs((take.motion.rotations[1:] * take.motion.rotations[:-1]).sum(-1))
        assert np.degrees(2 * np.arccos(np.clip(turns.min(), -1, 1))) < 30


def test_each_step_goes_on_from_the_last_frames(steps):
    seen = []

    def generate(requests, progress=lambda share: None):
        seen.append(requests)
        return fakes.generate(requests, progress)

    takes_of(*steps, tools=fakes.toolbox(generate))
    assert all(request.after is None for request in seen[0])
    for before, after in zip(seen[:-1], seen[1:], strict=True):
        assert len(before) == len(after) == 2
        for request in after:
            assert np.allclose(request.start_position[[0, 2]], request.after.root[-1, [0, 2]])
    # From the seat the way leads over the place beside it.
    assert np.linalg.norm(seen[1][0].waypoints[0] - seen[1][0].start_position) > 0.2


def test_a_step_that_fails_is_named(steps):
    calls = []

    def generate(requests, progress=lambda share: None):
        calls.append(requests[0].action)
        return (fakes.never if requests[0].action == "walk" else fakes.generate)(requests, progress)

    made, failures = takes_of(*steps, tools=fakes.toolbox(generate))
    assert not made and len(failures) == 2
    assert all(failure.message.startswith("Step 2: ") for failure in failures)
    assert "sit" not in calls[1:]
