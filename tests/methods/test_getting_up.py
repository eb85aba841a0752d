"""A body gets up from a bed as it lay down; chains in which it does hold the guarded measures."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.evaluation import guards, metrics
from samp_blender.samp_addon.evaluation.obstacles import shared
from samp_blender.samp_addon.methods import getting_up
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.methods.take import Take
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.pipeline import driver
from samp_blender.samp_addon.pipeline.driver import Work
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.tests.support import rooms
from views import view_of

STANDING = 0.95
WALK, DOWN, HOLD = 60, 60, 45


def lying_down(action="lie", pitch=np.pi / 2, floor=0.0):
    """Return a take that walks one metre, comes to rest and leans back by ``pitch``, its pelvis at 0.5 m."""
    away = np.concatenate([np.linspace(0, 1, WALK), np.linspace(1, 1.8, DOWN), np.full(HOLD, 1.8)])
    share = np.concatenate([np.zeros(WALK), np.linspace(0, 1, DOWN), np.ones(HOLD)])
    height = STANDING - share * (STANDING - 0.5)
    quats = np.zeros((len(share), 22, 4))
    quats[..., 0] = 1
    quats[:, 0] = rotation.from_axis_angle(np.outer(-pitch * share, [1.0, 0, 0]))
    actions = np.eye(5)[np.where(share > 0.5, 4, 1)]
    root = np.stack([np.zeros_like(away), height + floor, away], -1)
    motion = Motion(root, quats, actions=actions, contacts=np.zeros((len(share), 5)))
    goal = Goal(root[-1], np.array([0.0, 0, 1.0]), action)
    return Take(0, motion, goal=goal, waypoints=np.array([[0, floor, 0], [0, floor, 1.0]]))


@pytest.mark.parametrize("floor", [0.0, 3.0])
def test_it_gets_up_as_it_lay_down(floor):
    before = lying_down(floor=floor)
    up = getting_up.from_bed(before, STANDING)
    assert np.linalg.norm(up.root[0] - before.motion.root[-1]) < getting_up.RESTS
    assert up.root[-1, 1] - floor > getting_up.STANDS * STANDING and len(up) < WALK + DOWN
    rows = len(before.motion) - HOLD - np.arange(5, 40)
    assert np.allclose(up.root[[np.abs(up.root - before.motion.root[row]).sum(1).argmin() for row in rows]],
                       before.motion.root[rows])  # fmt: skip
    assert up.actions[0, 4] == 1 and up.actions[-1, 1] == 1


@pytest.mark.parametrize(
    "before",
    [
        lying_down("sit"),
        lying_down(pitch=0.0, floor=-0.45),  # never comes down: it stands at the end
        Take(0, lying_down().motion),
        Take(0, lying_down().motion.pose_slice(slice(-HOLD, None)), goal=lying_down().goal),
    ],
    ids=["sits", "stands", "without a goal", "lies from the start"],
)
def test_other_takes_go_on_as_they_end(before):
    assert getting_up.from_bed(before, STANDING if before.floor > -0.1 else 0.5) is None


def test_from_a_bed_to_the_floor_without_gliding():
    """The rollout alone glides through the air, at each of three attempts."""
    room = rooms.random_room(9001, rooms.bed)
    bed = view_of(room)
    back = SceneView(bed.geometry, destination=(room.start, None))
    job = Job("lie", "Bed", seed=3, then=(Step("walk", to=tuple(room.start)),))
    takes, failures = driver.run(Work(job, [bed, back]))
    assert not failures
    lies, walks = takes[0].steps
    numbers = metrics.measure(walks.motion, walks.goal, shared(bed.geometry.triangles), walks.floor)
    assert not guards.broken(numbers) and numbers["success"]
    assert np.linalg.norm(walks.motion.root[0] - lies.motion.root[-1]) < 0.1
    assert walks.motion.actions[0, 4] > 0.5, "it begins lying"
