"""Measures of the three stages of takes, and of what a network uses."""

from types import SimpleNamespace

import numpy as np
import pytest
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.samp.finishing import finish
from samp_blender.samp_addon.methods.samp.method import Samp
from samp_blender.samp_addon.methods.samp.request import Request
from samp_blender.samp_addon.methods.take import Take
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.tests.support import rooms
from samp_blender.training.evaluation import corrections, rows, stages
from samp_blender.training.evaluation.takes import view_of


@pytest.fixture(scope="module")
def sit():
    """Return a job of two sits in a room of boxes, with its view."""
    room = rooms.random_room(1003, rooms.sofa)
    return Job(action="sit", target="Target", seed=11, variants=2, hold=1.2), view_of(room, None), "sofa"


@pytest.fixture(scope="module")
def found(sit):
    return stages.measure([sit])


def test_every_stage_has_all_takes(found):
    assert list(found) == ["network", "guided", "finished", stages.HIDDEN, stages.Z_ALONE]
    for stage in found.values():
        assert len(stage.numbers) == len(stage.clusters) == 2
        assert len(stage.motions) + stage.failed == 2
    assert len(found["network"].motions) == len(found["guided"].motions) == 2  # also takes that got stuck


def test_finishing_brings_takes_onto_the_goal_which_the_network_alone_misses(found):
    raw, finished = (found[name].estimate("position_error_cm").mean for name in ("network", "finished"))
    assert raw > 1.5 * finished
    assert finished < 8


def test_the_table_has_a_column_for_each_stage(found):
    lines = stages.table("sit", found).splitlines()
    rows = {line.split("|")[1].strip(): line.split("|")[2:5] for line in lines if line.startswith("| ")}
    assert len(set(rows["PE, cm"])) == 3
    assert "walking: knee flexion, deg" in rows
    assert "Finishing moves the joints by" in lines[-3] and "z alone" in lines[-1]


def test_change_by_finishing_is_the_mean_distance_of_the_joints():
    rotations = np.zeros((90, 22, 4))
    rotations[..., 0] = 1
    before = Motion(np.zeros((90, 3)), rotations)
    after = Motion(np.repeat([[0.0, 0.0, 0.0], [0.0, 0.0, 0.03]], [30, 60], axis=0), rotations)
    found = {"guided": stages.Stage({(0, 1): before}), "finished": stages.Stage({(0, 1): after})}
    assert stages.changes_by_finishing(found) == pytest.approx((3.0, 2.0))


def test_versions_of_the_requests_differ_only_as_they_say():
    place = Goal(np.zeros(3), np.array([0.0, 0.0, 1.0]), "sit")
    triangles = np.zeros((1, 3, 3))
    asked = [Request(np.zeros(3), 0.0, "sit", place, object_triangles=triangles, seed=k) for k in (4, 5)]
    assert [r.object_triangles for r in stages.without_object(asked)] == [None, None]
    alone = stages.with_own_z(asked)
    assert [(r.seed, r.latent_seed) for r in alone] == [(4, 4), (4, 5)]


def test_an_earlier_stage_is_neither_snapped_nor_locked(sit):
    """The finished take is the guided one with its end moved: their beginnings agree, their ends do not."""
    job, view, _ = sit
    made = {}
    for stage in ("guided", "finished"):
        method = Samp(stages.networks_of_stage(stage))
        made[stage] = method.generate(job.steps[0], view, [Draw(12, 12)], lambda stage, share: None)[0][0]
    guided, finished = made["guided"].motion, made["finished"].motion
    assert len(guided) == len(finished)
    moved = np.linalg.norm(guided.root - finished.root, axis=-1)
    assert moved[20:60].max() < 0.05
    assert moved[-30:].mean() > 0.005
    sliding = [
        stages.all_measures(take, view)["stance_slide_cm_s"] for take in (made["guided"], made["finished"])
    ]
    assert sliding[0] > 2 * sliding[1]


@pytest.mark.parametrize(
    ("offset", "error"), [((0.0, 0.0, 0.0), 0.0), ((0.03, 0.0, 0.04), 5.0), ((0.0, 0.5, 0.0), 50.0)]
)
def test_errors_are_those_of_the_goal_on_the_object(offset, error, monkeypatch):
    rotations = np.zeros((60, 22, 4))
    rotations[..., 0] = 1
    goal = Goal(np.array([1.0, 0.6, 2.0]), np.array([0.0, 0.0, 1.0]), "sit")
    take = Take(1, Motion(np.tile(goal.position + offset, (60, 1)), rotations), goal=goal)
    monkeypatch.setattr(Samp, "generate", lambda *arguments: ([take], []))
    monkeypatch.setattr(stages, "all_measures", stages.goal_measures)
    found = stages.measure([(Job(action="sit", target="Seat"), SimpleNamespace(), "piece")])
    assert found["finished"].estimate("position_error_cm").mean == pytest.approx(error, abs=1e-6)
    assert found["finished"].estimate("rotation_error_deg").mean == pytest.approx(0.0, abs=1e-4)


def test_each_correction_is_left_out_in_turn(sit, monkeypatch):
    """Two of them: each takes as long as all takes."""
    monkeypatch.setattr(finish, "CORRECTIONS", ("goal", "limbs"))
    found = corrections.measure([sit])
    assert list(found) == ["all", *(f"without {name}" for name in finish.CORRECTIONS)]
    error = {name: stage.estimate("position_error_cm").mean for name, stage in found.items()}
    assert error["without goal"] > error["all"] + 1
    assert len(corrections.table("sit", found).splitlines()) == len(found) + 4


def test_a_place_that_cannot_be_found_counts_as_failed(sit, monkeypatch):
    def refuse(*arguments):
        raise SampError("There is no place.")

    monkeypatch.setattr(Samp, "generate", refuse)
    found = stages.measure([sit])
    assert [stage.failed for stage in found.values()] == [2] * 5
    assert found["network"].estimate("success").mean == 0
    assert "| takes that got stuck | 2 | 2 | 2 |" in stages.table("sit", found)


def test_networks_are_compared_in_three_stages_with_and_without_the_planner(sit, monkeypatch):
    """Requests of a network without the planner have two way-points; the finished stage has the fewest errors."""
    asked = []
    rotations = np.zeros((60, 22, 4))
    rotations[..., 0] = 1
    error = {"network": 0.2, "guided": 0.1, "finished": 0.01}

    def generate(requests, progress=None, network=None, stage=None, without=()):
        asked.append((network, [len(request.waypoints) for request in requests]))
        return [Motion(np.tile(r.goal.position + [error[stage], 0, 0], (60, 1)), rotations) for r in requests]

    monkeypatch.setattr(stages.generator, "generate", generate)
    versions = {"a": rows.Version("a"), "a, no planner": rows.Version("a", planner=False)}
    found = rows.measure([sit], versions)
    assert [name for name, _ in asked] == ["a"] * 6
    assert min(n for _, counts in asked[:3] for n in counts) > 2
    assert all(counts == [2, 2] for _, counts in asked[3:])
    lines = rows.table("sit", found).splitlines()[4:]
    cells = [[cell.strip() for cell in line.split("|")[1:5]] for line in lines]
    assert [(row[0], row[1]) for row in cells] == [(name, stage) for name in versions for stage in error]
    assert [float(row[3].split()[0]) for row in cells] == [20.0, 10.0, 1.0] * 2
