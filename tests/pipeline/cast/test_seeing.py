"""Members whose methods need the other bodies over time are generated one after another, each with those before it."""

import numpy as np
import pytest
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.body.balls import Track
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.take import Take
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline import driver
from samp_blender.samp_addon.pipeline.beside_others import beside
from samp_blender.samp_addon.pipeline.cast import directing, seeing
from samp_blender.samp_addon.pipeline.cast.cast import Cast, Member
from samp_blender.samp_addon.pipeline.cast.role import CastWork, Other, Role
from samp_blender.samp_addon.pipeline.driver import Toolbox, Work
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from shapes import box

FLOOR = SceneGeometry.from_objects([("Floor", box((-4, -0.1, -4), (4, 0, 4)))])
JOB = Job(action="", method="scene_gan")


class Standing:
    """A method whose takes stand still for one second. received: the other characters, for each call."""

    name, label, description, actions, options, batch_size = "scene_gan", "", "", (), (), 4
    needs = frozenset({"start", "others"})

    def __init__(self):
        self.received = []

    def generate(self, step, scene, draws, progress):
        self.received.append(list(scene.others))
        root = np.tile(scene.start[0] + [0.0, -human.load().floor, 0.0], (31, 1))
        pose = np.tile([1.0, 0.0, 0.0, 0.0], (31, 22, 1))
        contacts, actions = np.zeros((31, 5)), np.zeros((31, 5))
        return [Take(draw.seed, Motion(root, pose, contacts=contacts, actions=actions)) for draw in draws], []


def track(*xs):
    """A ball that is at these places, one for each frame of the schedule."""
    return Track(np.array([[[x, 1.0, 0.0]] for x in xs], float), np.array([0.2]), directing.RATE)


def view(x):
    return SceneView(FLOOR, start=(np.array([x, 0.0, 0.0]), 0.0))


@pytest.mark.parametrize("frames, places", [(0, [1, 2, 3]), (2, [1, 1, 1, 2, 3]), (-1, [2, 3]), (-7, [3])])
def test_a_body_that_begins_later_or_earlier(frames, places):
    assert seeing.late(track(1, 2, 3), frames).centres[:, 0, 0].tolist() == places


def test_each_member_knows_those_before_it():
    """With their delays: a member that begins a second later is given the others from that second on."""
    method = Standing()
    ann, ben, cem = (
        Role(Member(JOB, name, delay), ("",), ((view(x),),), human.load())
        for name, x, delay in (("Ann", -2.0, 0.0), ("Ben", 0.0, 1.0), ("Cem", 2.0, 0.0))
    )
    passer = Other("Dora", track(*np.linspace(-3, -2.5, 21)), np.array([-2.5, 0.95, 2.0]))
    cast = Cast(tuple(role.member for role in (ann, ben, cem)))
    (made,) = directing.run(CastWork(cast, (ann, ben, cem), (passer,)), tools=Toolbox({"scene_gan": method}))
    assert not made.failures and [len(others) for others in method.received] == [1, 2, 3]
    for others, start in zip(method.received, (-3.0, -2.75, -3.0), strict=True):
        assert others[-1].centres[0, 0, 0] == pytest.approx(start)
    assert method.received[1][0].centres[0].mean(0)[0] == pytest.approx(-2.0, abs=0.1)  # Ann
    assert (
        len(method.received[2][1]) == len(method.received[2][0]) + directing.RATE
    )  # Ben, from a second later on


def test_a_character_beside_others_knows_their_ways():
    method, passer = Standing(), Other("Dora", track(3.0, 2.0), np.array([2.0, 0.95, 0.0]))
    work = beside(Work(JOB, [view(0.0)], body=human.load()), [passer])
    takes, failures = driver.run(work, tools=Toolbox({"scene_gan": method}))
    assert len(takes) == 1 and not failures
    assert [other.centres[0, 0, 0] for other in method.received[0]] == [3.0]
