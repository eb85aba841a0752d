"""PE and RE of the three stages of takes, and the measures that finishing could hide."""

import numpy as np
import pytest
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.evaluation import metrics
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.samp.method import Samp
from samp_blender.samp_addon.methods.take import Take
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.tests.support import rooms
from samp_blender.training.evaluation import stages
from samp_blender.training.evaluation.takes import view_of


@pytest.fixture(scope="module")
def sit():
    """Return a job of one sit in a room of boxes, with its view."""
    room = rooms.random_room(1003, rooms.sofa)
    return Job(action="sit", target="Target", seed=11, hold=1.2), view_of(room, None), "sofa"


@pytest.fixture(scope="module")
def found(sit):
    return stages.measure([sit])


def test_every_stage_has_all_takes(found):
    assert list(found) == ["network", "guided", "finished"]
    for errors in found.values():
        assert len(errors.position) + errors.failed == 1
        assert set(errors.clusters) <= {"sofa"}
    assert len(found["network"].position) == len(found["guided"].position) == 1  # also takes that got stuck


def test_finishing_brings_takes_onto_the_goal_which_the_network_alone_misses(found):
    raw, finished = (np.array(found[name].position) for name in ("network", "finished"))
    assert raw.max() > 2 * finished.max()
    assert finished.max() < 8


def test_stages_are_told_apart_in_the_table(found):
    lines = stages.table("sit", found).splitlines()
    assert [line.split("|")[1].strip() for line in lines[4:]] == ["network", "guided", "finished"]
    assert len({line.split("|")[4] for line in lines[4:]}) == 3


def test_an_earlier_stage_is_neither_snapped_nor_locked(sit):
    """The finished take is the guided one with its end moved: their beginnings agree, their ends do not."""
    job, view, _ = sit
    made = {}
    for stage in ("guided", "finished"):
        method = Samp(stages.networks_of_stage(stage))
        made[stage] = method.generate(job.steps[0], view, [Draw(11, 11)], lambda stage, share: None)[0][0]
    guided, finished = made["guided"].motion, made["finished"].motion
    assert len(guided) == len(finished)
    assert np.linalg.norm(guided.root[20:60] - finished.root[20:60], axis=-1).max() < 0.05
    goal = made["finished"].goal
    assert metrics.position_error(guided, goal) > metrics.position_error(finished, goal)


@pytest.mark.parametrize(
    ("offset", "error"), [((0.0, 0.0, 0.0), 0.0), ((0.03, 0.0, 0.04), 5.0), ((0.0, 0.5, 0.0), 50.0)]
)
def test_errors_are_those_of_the_goal_on_the_object(offset, error):
    rotations = np.zeros((60, 22, 4))
    rotations[..., 0] = 1
    goal = Goal(np.array([1.0, 0.6, 2.0]), np.array([0.0, 0.0, 1.0]), "sit")
    errors = stages.StageErrors()
    errors.add([Take(1, Motion(np.tile(goal.position + offset, (60, 1)), rotations), goal=goal)], "piece")
    assert errors.position == pytest.approx([error], abs=1e-6)
    assert errors.rotation == pytest.approx([0.0], abs=1e-4)


def test_a_place_that_cannot_be_found_counts_as_failed(sit, monkeypatch):
    def refuse(*arguments):
        raise SampError("There is no place.")

    monkeypatch.setattr(Samp, "generate", refuse)
    found = stages.measure([sit])
    assert [errors.failed for errors in found.values()] == [1, 1, 1]
    assert stages.table("sit", found).count("| - | - |") == 3
