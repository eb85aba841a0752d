"""Way-points on the floor, how fast a take is, and what a watcher is shown."""

import bpy
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import progress
from samp_blender.samp_addon.blender.overlays import waypoints
from samp_blender.samp_addon.methods.take import Situation, Tools
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline import chain
from samp_blender.samp_addon.pipeline.job import Job, UsageError, order
from samp_blender.samp_addon.scene.geometry import SceneGeometry

FLOOR = rooms.box(np.array([-4.0, -0.1, -4.0]), np.array([4.0, 0.0, 4.0]))


@pytest.fixture
def context():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return bpy.context


def walked(request, seconds=2.0):
    """A body that is at once where it was sent."""
    frames = round((seconds + request.hold_seconds) * 30) + 1
    rotations = np.tile([1.0, 0, 0, 0], (frames, 22, 1))
    root = np.tile(request.goal.position + [0.0, chain.standing_height(), 0.0], (frames, 1))
    return Motion(root, rotations)


def made(job, **situation):
    """The requests and takes of a job on an empty floor."""
    seen = []

    def generate(requests, told):
        seen.extend(requests)
        progress.show(told, walked(requests[0]))
        return [walked(request) for request in requests]

    scene = SceneGeometry(FLOOR, np.zeros(len(FLOOR), int), ["Floor"])
    around = Situation(
        scene, start=(np.zeros(3), 0.0), destination=(np.array([2.0, 0, 0]), None), **situation
    )
    takes, failures = chain.synthesise(job, around, tools=Tools(None, generate))
    assert not failures
    return seen, takes


def test_the_way_passes_the_artists_places():
    via = [np.array([-2.0, 0.0, 2.0]), np.array([2.0, 0.0, 2.0])]
    seen, takes = made(Job(action="walk", to=(2.0, 0.0, 0.0)), via=via)
    for place in via:
        assert np.linalg.norm(seen[0].waypoints - place, axis=-1).min() < 0.06
    order_ = [int(np.argmin(np.linalg.norm(seen[0].waypoints - place, axis=-1))) for place in via]
    assert order_ == sorted(order_) and np.allclose(takes[0].waypoints[-1], [2.0, 0.0, 0.0], atol=0.06)


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_speed_is_the_motions_not_the_holds(speed):
    _, takes = made(Job(action="walk", to=(2.0, 0.0, 0.0), speed=speed, hold=1.0))
    assert takes[0].motion.seconds == pytest.approx(2.0 / speed + 1.0, abs=0.05)
    assert takes[0].motion.fps == 30.0


def test_style_reaches_the_network():
    assert made(Job(action="walk", to=(2.0, 0.0, 0.0), style=0.4))[0][0].style == 0.4


@pytest.mark.parametrize("options", [{"style": -0.1}, {"style": 2.0}, {"speed": 0.1}, {"speed": 9.0},
                                     {"via": ((1.0, 2.0),)}, {"via": ((1.0, 2.0, float("nan")),)}])  # fmt: skip
def test_what_cannot_be_used_is_refused(options):
    with pytest.raises(UsageError, match="--" + next(iter(options))):
        Job(action="walk", to=(0.0, 0.0, 0.0), **options)


@pytest.mark.parametrize("told", [[1, 2, 3, 4, 5, 6], [[1, 2, 3], [4, 5, 6]]])
def test_places_come_flat_or_one_by_one(told):
    made_ = order({"action": "walk", "to": [0, 0, 0], "via": told, "output": "a.blend"})
    assert made_.job.via == ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))


def test_waypoints_are_read_where_they_were_dragged_to(context):
    assert waypoints.places(context) == []
    first, second = waypoints.add(context, (1, 2, 0)), waypoints.add(context, (3, 4, 0))
    first.location.x = 5.0
    context.view_layer.update()
    np.testing.assert_allclose(waypoints.places(context), [[5.0, 0.0, -2.0], [3.0, 0.0, -4.0]], atol=1e-6)
    second.hide_set(True)
    assert len(waypoints.places(context)) == 1
    assert waypoints.clear(context) == 2 and not bpy.data.objects
    assert not any(c.name.startswith(waypoints.COLLECTION) for c in bpy.data.collections)


def test_parts_of_work_tell_and_show_the_whole():
    class Whole:
        def __init__(self):
            self.told, self.seen = [], []

        def __call__(self, stage, share):
            self.told.append((stage, share))

        def show(self, motion):
            self.seen.append(motion)

    whole, motion = Whole(), Motion(np.zeros((1, 3)), np.tile([1.0, 0, 0, 0], (1, 22, 1)))
    stage = progress.StageProgress(progress.SubProgress(whole, 0.5, 0.5), "Moving")
    stage(0.5)
    progress.show(stage, motion)
    progress.show(lambda share: None, motion)
    assert whole.told == [("Moving", 0.75)] and whole.seen == [motion]
