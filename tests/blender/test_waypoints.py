"""Way-points on the floor, speed and style of takes, and previews."""

import json

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import progress
from samp_blender.samp_addon.batch import jobs_file
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.blender.overlays import waypoints
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.methods.samp import planning
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from views import takes_of

FLOOR = rooms.box(np.array([-4.0, -0.1, -4.0]), np.array([4.0, 0.0, 4.0]))


@pytest.fixture
def context():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return bpy.context


def walked(request, seconds=2.0):
    """Return motions that reach their goal at once."""
    frames = round((seconds + request.hold_seconds) * 30) + 1
    rotations = np.tile([1.0, 0, 0, 0], (frames, 22, 1))
    root = np.tile(request.goal.position + [0.0, planning.standing_height(), 0.0], (frames, 1))
    return Motion(root, rotations)


def made(job, **situation):
    """Return the requests and takes of a job on an empty floor."""
    seen = []

    def generate(requests, report):
        seen.extend(requests)
        progress.show(report, walked(requests[0]))
        return [walked(request) for request in requests]

    scene = SceneGeometry(FLOOR, np.zeros(len(FLOOR), int), ["Floor"])
    around = SceneView(
        scene, start=(np.zeros(3), 0.0), destination=(np.array([2.0, 0, 0]), None), **situation
    )
    takes, failures = takes_of(job, around, tools=fakes.toolbox(generate))
    assert not failures
    return seen, takes


def test_path_passes_the_way_points():
    via = [np.array([-2.0, 0.0, 2.0]), np.array([2.0, 0.0, 2.0])]
    seen, takes = made(Job(action="walk", to=(2.0, 0.0, 0.0)), via=via)
    for place in via:
        assert np.linalg.norm(seen[0].waypoints - place, axis=-1).min() < 0.06
    order_ = [int(np.argmin(np.linalg.norm(seen[0].waypoints - place, axis=-1))) for place in via]
    assert order_ == sorted(order_) and np.allclose(takes[0].waypoints[-1], [2.0, 0.0, 0.0], atol=0.06)


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_speed_scales_the_motion_but_not_the_hold(speed):
    _, takes = made(Job(action="walk", to=(2.0, 0.0, 0.0), speed=speed, hold=1.0))
    assert takes[0].motion.seconds == pytest.approx(2.0 / speed + 1.0, abs=0.05)
    assert takes[0].motion.fps == 30.0


def test_style_is_passed_to_the_network():
    assert made(Job(action="walk", to=(2.0, 0.0, 0.0), style=0.4))[0][0].style == 0.4


@pytest.mark.parametrize("options", [{"style": -0.1}, {"style": 2.0}, {"speed": 0.1}, {"speed": 9.0},
                                     {"via": ((1.0, 2.0),)}, {"via": ((1.0, 2.0, float("nan")),)}])  # fmt: skip
def test_invalid_options_raise(options):
    with pytest.raises(UsageError, match="--" + next(iter(options))):
        Job(action="walk", to=(0.0, 0.0, 0.0), **options)


@pytest.mark.parametrize("via", [[1, 2, 3, 4, 5, 6], [[1, 2, 3], [4, 5, 6]]])
def test_via_is_flat_or_nested(via):
    line = json.dumps({"action": "walk", "to": [0, 0, 0], "via": via, "output": "a.blend"})
    made_ = order(jobs_file.options(line, {}))
    assert made_.job.via == ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))


def test_positions_of_moved_way_points(context):
    assert waypoints.positions(context) == []
    first, second = waypoints.add(context, (1, 2, 0)), waypoints.add(context, (3, 4, 0))
    first.location.x = 5.0
    context.view_layer.update()
    np.testing.assert_allclose(waypoints.positions(context), [[5.0, 0.0, -2.0], [3.0, 0.0, -4.0]], atol=1e-6)
    second.hide_set(True)
    assert len(waypoints.positions(context)) == 1
    assert waypoints.clear(context) == 2 and not bpy.data.objects
    assert not any(c.name.startswith(waypoints.COLLECTION) for c in bpy.data.collections)


def test_parts_report_progress_to_the_whole():
    class Whole:
        def __init__(self):
            self.reports, self.seen = [], []

        def __call__(self, stage, share):
            self.reports.append((stage, share))

        def show(self, motion):
            self.seen.append(motion)

    whole, motion = Whole(), Motion(np.zeros((1, 3)), np.tile([1.0, 0, 0, 0], (1, 22, 1)))
    stage = progress.StageProgress(progress.SubProgress(whole, 0.5, 0.5), "Moving")
    stage(0.5)
    progress.show(stage, motion)
    progress.show(lambda share: None, motion)
    assert whole.reports == [("Moving", 0.75)] and whole.seen == [motion]
