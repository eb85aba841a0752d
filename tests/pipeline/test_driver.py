"""From a job and its scene to takes, without Blender; fakes stand in for the networks."""

from __future__ import annotations

from dataclasses import replace

import fakes
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.evaluation import metrics
from samp_blender.samp_addon.pipeline import attempts
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from views import takes_of, view_of

SIT = Job(action="sit", target="Sofa", hold=1.5)


@pytest.fixture(scope="module")
def room():
    return rooms.random_room(1, rooms.sofa)


@pytest.fixture(scope="module")
def takes(room):
    made, failures = takes_of(replace(SIT, seed=3, variants=3), view_of(room))
    assert not failures
    return made


def test_each_seed_gives_a_take_that_sits_down(room, takes):
    assert [take.seed for take in takes] == [3, 4, 5]
    for take in takes:
        assert metrics.success(take.motion, take.goal)
        assert take.attempts == 1
        assert take.motion.interaction_start > 0
        assert set(take.seconds) >= {"goal", "path", "rollout"}


def test_the_way_goes_around_the_furniture(room, takes):
    for take in takes:
        np.testing.assert_allclose(take.waypoints[0, [0, 2]], room.start[[0, 2]], atol=0.05)
        assert not room.crossings(take.waypoints)


def test_a_seed_gives_the_same_take_whatever_runs_beside_it(room, takes):
    alone, _ = takes_of(replace(SIT, seed=4), view_of(room))
    np.testing.assert_array_equal(alone[0].motion.root, takes[1].motion.root)
    assert np.abs(takes[0].motion.root[-1] - takes[1].motion.root[-1]).max() > 1e-3


def test_the_artists_goals_are_taken(room):
    chosen = fakes.sample_goals(room.target.triangles, "sit", 2, 0, None)[1]
    view = view_of(room, goals=[chosen])
    take = takes_of(SIT, view, tools=fakes.toolbox(sample_goals=None))[0][0]
    np.testing.assert_array_equal(take.goal.position, chosen.position)


def test_a_free_start_is_found_the_same_for_the_same_seed(room):
    view = view_of(room, start=None)
    first, second, other = (takes_of(replace(SIT, seed=s), view)[0][0] for s in (7, 7, 8))
    np.testing.assert_array_equal(first.waypoints, second.waypoints)
    assert np.linalg.norm(first.waypoints[0] - other.waypoints[0]) > 0.1
    assert not any(piece.covers(first.waypoints[:1], 0.15).any() for piece in room.pieces)


@pytest.mark.parametrize("action", ["walk", "run"])
def test_walks_end_where_they_shall(room, action):
    place = np.array([-room.start[0] * 0.2, 0.0, 3.5])
    job = Job(action=action, to=(0.0, 0.0, 0.0))
    view = view_of(room, target=None, parts=(), destination=(place, 1.0))
    take = takes_of(job, view)[0][0]
    np.testing.assert_allclose(take.goal.direction, frames.yaw_direction(1.0))
    np.testing.assert_allclose(take.goal.position[[0, 2]], place[[0, 2]])
    assert 0.8 < take.goal.position[1] < 1.1
    assert metrics.success(take.motion, take.goal)


def test_a_walk_without_a_facing_ends_in_the_direction_of_the_way(room):
    view = view_of(room, target=None, parts=(), destination=(np.array([0.0, 0.0, 3.6]), None))
    take = takes_of(Job(action="walk", to=(0, 0, 0)), view)[0][0]
    step = take.waypoints[-1] - take.waypoints[-2]
    np.testing.assert_allclose(take.goal.direction, step / np.linalg.norm(step), atol=1e-6)


def test_a_walk_to_an_object_ends_before_it_and_faces_it(room):
    take = takes_of(Job(action="walk", target="Sofa"), view_of(room))[0][0]
    towards = room.target.at - take.goal.position[[0, 2]]
    assert not room.target.covers(take.goal.position[None], 0.1).any()
    assert np.linalg.norm(towards) < 2
    assert take.goal.direction[[0, 2]] @ towards / np.linalg.norm(towards) > 0.95


def test_idle_stays(room):
    take = takes_of(Job(action="idle"), view_of(room, target=None))[0][0]
    np.testing.assert_allclose(take.motion.root[-1][[0, 2]], room.start[[0, 2]], atol=0.1)


def test_a_failed_attempt_is_made_again_with_other_noise(room):
    tried = []

    def sometimes(requests, progress):
        tried.append(requests[0].seed)
        return fakes.never(requests) if len(tried) < 2 else fakes.generate(requests)

    takes, failures = takes_of(SIT, view_of(room), tools=fakes.toolbox(sometimes))
    assert (takes[0].attempts, failures) == (2, [])
    assert len(set(tried)) == 2


@pytest.mark.parametrize("sunk, attempts", [(0.15, 2), (0.05, 1)])
def test_who_stoops_at_the_end_of_a_walk_tries_again(room, sunk, attempts):
    depths = iter([sunk, 0.0])

    def stooping(requests, progress):
        motion = fakes.generate(requests)[0]
        return [replace(motion, root=motion.root - [0, next(depths), 0])]

    job = Job(action="walk", target="Sofa")
    take = takes_of(job, view_of(room), tools=fakes.toolbox(stooping))[0][0]
    assert take.attempts == attempts


def test_a_take_beside_its_goal_is_made_again_and_the_nearest_one_kept(room):
    distances = iter([1.0, 0.5, 0.8])

    def beside(requests, progress):
        motion = fakes.generate(requests)[0]
        return [replace(motion, root=motion.root + [next(distances), 0, 0])]

    take = takes_of(SIT, view_of(room), tools=fakes.toolbox(beside))[0][0]
    assert take.attempts == 2
    assert metrics.position_error(take.motion, take.goal) == pytest.approx(50, abs=3)


def test_failures_name_their_seed_and_the_others_go_on(room):
    def but_the_second(requests, progress):
        unlucky = lambda request: request.seed % attempts.NEXT_ATTEMPT == 5
        return [(fakes.never if unlucky(request) else fakes.generate)([request])[0] for request in requests]

    takes, failures = takes_of(
        replace(SIT, seed=4, variants=3), view_of(room), tools=fakes.toolbox(but_the_second)
    )
    assert [take.seed for take in takes] == [4, 6]
    assert [(failure.seed, "stuck" in failure.message) for failure in failures] == [(5, True)]


def closed_off(room):
    wall = lambda low, high: rooms.box(low, high)
    x, z = room.start[0], room.start[2]
    return np.concatenate(
        [
            wall((x - 0.6, 0, z - 0.6), (x + 0.6, 2, z - 0.5)),
            wall((x - 0.6, 0, z + 0.5), (x + 0.6, 2, z + 0.6)),
            wall((x - 0.6, 0, z - 0.6), (x - 0.5, 2, z + 0.6)),
            wall((x + 0.5, 0, z - 0.6), (x + 0.6, 2, z + 0.6)),
        ]
    )


def test_no_way_and_no_place_say_so(room):
    view = view_of(room)
    cage = SceneGeometry.from_objects(
        [("Floor", room.floor), ("Sofa", room.target.triangles), ("Cage", closed_off(room))]
    )
    assert takes_of(SIT, replace(view, geometry=cage))[1][0].message
    nowhere = fakes.toolbox(sample_goals=lambda *arguments: [])
    message = takes_of(SIT, view, tools=nowhere)[1][0].message
    assert message.startswith("There is no place to sit on 'Sofa'; ")


class Stop(Exception):
    pass


@pytest.mark.parametrize("stage", ["Loading", "Finding the floor", "Choosing a place", "Moving"])
def test_progress_stops_the_work_at_every_stage(room, stage):
    def progress(name, share):
        assert 0 <= share <= 1
        if name == stage:
            raise Stop

    with pytest.raises(Stop):
        takes_of(SIT, view_of(room), progress=progress)


def test_who_is_sent_into_an_obstacle_stands_beside_it(room):
    piece = room.pieces[1]
    place = np.array([piece.at[0], 0.0, piece.at[1]])
    view = view_of(room, target=None, parts=(), destination=(place, None))
    take = takes_of(Job(action="walk", to=tuple(place)), view)[0][0]
    assert not any(other.covers(take.goal.position[None], 0.15).any() for other in room.pieces)
    assert np.linalg.norm(take.goal.position[[0, 2]] - place[[0, 2]]) < 1.0
