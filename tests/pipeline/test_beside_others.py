"""One character beside others that are in the scene: places that are not free, ways around them, waiting."""

from __future__ import annotations

import fakes
import numpy as np
import pytest
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.body.balls import Track
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.evaluation.between_bodies import over_time
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.pipeline import driver
from samp_blender.samp_addon.pipeline.beside_others import beside, free_goals
from samp_blender.samp_addon.pipeline.cast.cast_take import track
from samp_blender.samp_addon.pipeline.cast.directing import RATE
from samp_blender.samp_addon.pipeline.cast.role import Other
from samp_blender.samp_addon.pipeline.driver import Work
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from shapes import box

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
FLOOR = ("Floor", box((-4, -0.1, -4), (4, 0, 4)))
BENCH = ("Bench", box((-1.2, 0, -0.25), (1.2, 0.45, 0.25)))
STOOL = ("Stool", box((-0.22, 0, -0.22), (0.22, 0.45, 0.22)))


def body(*places, seconds=1.0, tall=1.7, name="Ann"):
    """An upright body, three columns of balls, that goes from place to place, each for some seconds."""
    way = np.array([np.asarray(place, float) for place in places])
    rows = np.minimum(np.arange(round(seconds * RATE) * len(way)) // round(seconds * RATE), len(way) - 1)
    heights = np.linspace(0.1, tall - 0.1, 12)
    column = np.concatenate([[[x, y, 0.0] for y in heights] for x in (-0.12, 0.0, 0.12)])
    centres = way[rows][:, None] + column
    pelvis = way[-1] + [0.0, min(tall / 2, 0.95), 0.0]
    return Other(name, Track(centres, np.full(len(column), 0.12), RATE), pelvis)


def sitting(x, z=0.0, name="Ann"):
    """A body on a seat of 45 cm at x, z, its head at 1.3 m."""
    made = body([x, 0.35, z], tall=0.95, name=name)
    return Other(name, made.track, np.array([x, 0.63, z]))


def work(piece, job=None, **view):
    scene = SceneGeometry.from_objects([FLOOR, piece] if piece else [FLOOR])
    found = {} if piece is None else {"target": piece[1], "parts": (piece[0],)}
    default = Job(action="sit", target=piece[0], hold=1.0) if piece else None
    start = view.pop("start", (np.array([0.0, 0.0, 3.0]), np.pi))
    return Work(job or default, [SceneView(scene, start=start, **found, **view)], body=human.load())


@pytest.mark.parametrize(
    ("goal", "others", "free"),
    [
        (Goal(np.array([0.0, 0.63, 0.0]), Z, "sit"), [], True),
        (Goal(np.array([0.0, 0.63, 0.0]), Z, "sit"), [sitting(0.0)], False),
        (Goal(np.array([0.0, 0.63, 0.0]), Z, "sit"), [sitting(0.4)], False),
        (Goal(np.array([0.0, 0.63, 0.0]), Z, "sit"), [sitting(0.6)], True),
        # Somebody stands where the knees would be.
        (Goal(np.array([0.0, 0.63, 0.0]), Z, "sit"), [body([0.0, 0.0, 0.48])], False),
        # Another storey.
        (Goal(np.array([0.0, 3.63, 0.0]), Z, "sit"), [sitting(0.0)], True),
        # At the feet of somebody who lies, and one who lies where others sit.
        (Goal(np.array([0.0, 0.57, 0.0]), X, "lie"), [sitting(0.7)], False),
        (Goal(np.array([0.0, 0.57, 0.0]), X, "lie"), [sitting(1.4)], True),
        (Goal(np.array([0.0, 0.57, 0.0]), X, "lie"), [sitting(0.0, 0.6)], True),
    ],
)
def test_places_at_which_somebody_is_are_not_free(goal, others, free):
    assert bool(free_goals([goal], others)) is free


def test_nothing_changes_where_nobody_is():
    asked = work(BENCH)
    assert beside(asked, []) is asked


def test_the_next_place_on_a_bench_is_taken():
    asked = work(BENCH)
    alone = driver.run(asked, tools=fakes.TOOLS)[0][0]
    ann = sitting(float(alone.goal.position[0]))
    (take,), failures = driver.run(beside(asked, [ann]), tools=fakes.TOOLS)
    assert not failures
    assert abs(take.goal.position[0] - ann.pelvis[0]) >= 0.45


def test_a_stool_has_one_place():
    with pytest.raises(SampError, match="'Ann' is already on 'Stool'; move that character away"):
        beside(work(STOOL), [sitting(0.0)])


def walk(to):
    return Job(action="walk", to=(0.0, 0.0, 0.0), hold=1.0), {"destination": (np.array(to), None)}


def test_the_way_leads_around_somebody_who_stands_on_it():
    job, view = walk([0.0, 0.0, -3.0])
    ann = body([0.0, 0.0, 0.0], seconds=9.0)
    (take,), _ = driver.run(beside(work(None, job, **view), [ann]), tools=fakes.TOOLS)
    # The arms of the fake takes are stretched out and may touch her.
    assert np.linalg.norm(take.motion.root[:, [0, 2]], axis=-1).min() > 0.4


def test_it_waits_for_somebody_who_passes():
    job, view = walk([0.0, 0.0, -3.0])
    asked = work(None, job, **view)
    alone = driver.run(asked, tools=fakes.TOOLS)[0][0]
    # Ann is on the way just when the character would come by, and leaves.
    ann = body([0.3, 0.0, 0.0], [3.0, 0.0, 0.0], seconds=4.0)
    (take,), _ = driver.run(beside(asked, [ann]), tools=fakes.TOOLS)
    assert len(take.motion) > len(alone.motion) + 10
    assert float(over_time(track(take.motion, human.load(), RATE), ann.track).max()) < 0.02
    np.testing.assert_allclose(take.motion.root[-1], alone.motion.root[-1], atol=0.05)


def test_a_meeting_that_cannot_be_avoided_is_told():
    job, view = walk([0.0, 0.0, -3.0])
    corridor = ("Walls", np.concatenate([box((-4, 0, -2), (-0.4, 2.5, 2)), box((0.4, 0, -2), (4, 2.5, 2))]))
    scene = SceneGeometry.from_objects([FLOOR, corridor])
    start = (np.array([0.0, 0.0, 3.0]), np.pi)
    asked = Work(job, [SceneView(scene, start=start, **view)], body=human.load())
    (take,), failures = driver.run(beside(asked, [body([0.0, 0.0, 0.0])]), tools=fakes.TOOLS)
    assert not failures
    assert any("cm in that of 'Ann'" in remark for remark in take.remarks)
