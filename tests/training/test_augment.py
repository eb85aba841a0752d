"""Other paces and ways of captured motion, runs joined from short ones, and the checks that a clip has to pass."""

from dataclasses import replace

import numpy as np
import pytest
from clips import clip
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.scene.geometry import sample_surface
from samp_blender.samp_addon.scene.seats.postures import SEAT_TO_PELVIS
from samp_blender.training.composition import checks, sits
from samp_blender.training.composition.runs import RunComposer
from samp_blender.training.composition.stitch import WalkIndex
from samp_blender.training.mocap import augment, events, natural
from samp_blender.training.mocap.clip_files import FPS
from shapes import box

JOINTS = skeleton.INDEX


@pytest.mark.parametrize("factor", [0.5, 0.8, 1.0, 1.3])
def test_another_pace_is_the_same_way_in_another_time(factor):
    walk = clip(61, velocity=(0, 0, 1.0))
    quick = augment.paced(walk, factor)
    assert len(quick) == pytest.approx(60 / factor + 1, abs=1)
    assert np.allclose(quick.root[[0, -1]], walk.root[[0, -1]])
    speed = np.linalg.norm(np.diff(quick.root, axis=0), axis=-1) * FPS
    assert np.allclose(speed, factor, rtol=0.03)
    assert len(quick.labels) == len(quick.feet) == len(quick.bad) == len(quick)


def test_no_pace_is_refused():
    with pytest.raises(ValueError, match="has to be positive"):
        augment.paced(clip(5), 0.0)


@pytest.mark.parametrize("curvature", [-0.4, 0.0, 0.4])
def test_a_way_is_bent_and_faces_along_itself(curvature):
    walk = clip(121, velocity=(0, 0, 1.0))
    bent = augment.bent(walk, curvature)
    steps = np.diff(bent.root[:, [0, 2]], axis=0)
    assert np.allclose(np.linalg.norm(steps, axis=-1) * FPS, 1.0, atol=1e-6), "as fast as before"
    course = np.unwrap(np.arctan2(steps[:, 0], steps[:, 1]))
    assert course[-1] - course[0] == pytest.approx(curvature * 4, abs=0.05)
    ahead = rotation.rotate(bent.rotations[:-1, 0], np.array([0.0, 0, 1]))
    assert np.allclose(np.unwrap(np.arctan2(ahead[:, 0], ahead[:, 2])), course, atol=0.02)


def test_who_stands_is_not_turned():
    standing = clip(30, label="idle")
    assert np.allclose(augment.bent(standing, 1.0).rotations, standing.rotations)


@pytest.mark.parametrize(
    "spoil, why",
    [
        (lambda c: c, None),
        (lambda c: replace(c, root=c.root * np.nan), "not finite"),
        (lambda c: clip(40, pose=(("left_knee", 170),)), "joints past their limits"),
        (lambda c: replace(c, root=c.root + np.arange(40)[:, None] * [0, 0, 0.5]), "jumps"),
        (lambda c: replace(c, feet=np.ones((40, 2)), root=c.root + np.arange(40)[:, None] * [0, 0, 0.005]),
         "feet slide"),
    ],
)  # fmt: skip
def test_faults_are_found(spoil, why):
    assert checks.fault(spoil(clip(40))) == why


def test_what_is_marked_bad_is_not_held_against_a_clip():
    jumping = clip(40)
    root = jumping.root.copy()
    root[20:] += [0, 0, 1.0]
    bad = np.zeros(40, bool)
    assert checks.fault(replace(jumping, root=root)) == "jumps"
    bad[18:22] = True
    assert checks.fault(replace(jumping, root=root, bad=bad)) is None


@pytest.mark.parametrize("height, bow, label, bends", [(0.93, 0, "idle", False), (0.75, 0, "idle", True),
                                                       (0.93, 60, "walk", True), (0.93, 20, "walk", False),
                                                       (0.6, 0, "sit", False)])  # fmt: skip
def test_bending_down_is_not_learnt(height, bow, label, bends):
    one = clip(30, root=(0.0, height, 0.0), pose=(("spine1", bow),), label=label)
    assert natural.bending(one).all() == bends and natural.bending(one).any() == bends


SEAT = box((-0.3, 0.4, -0.3), (0.3, 0.45, 0.3))


@pytest.mark.parametrize("over, x, why", [(SEAT_TO_PELVIS, 0.0, None), (SEAT_TO_PELVIS + 0.12, 0.0, "hovers over it"),
                                          (SEAT_TO_PELVIS - 0.09, 0.0, "sits too deep"),
                                          (SEAT_TO_PELVIS, 0.6, "nothing under it")])  # fmt: skip
def test_a_sit_touches_its_seat(over, x, why):
    surface, _ = sample_surface(SEAT, 6000, seed=0)
    piece = sits.Furnishing(
        0, surface, [Goal(np.array([0.0, 0.45 + SEAT_TO_PELVIS, 0.0]), np.array([0.0, 0, 1]))]
    )
    assert sits.untouched(np.array([x, 0.45 + over, 0.0]), piece, (0.0, 0.0, 0.0)) == why


@pytest.mark.parametrize("height, why", [(0.62, None), (0.47, "trunk in the mattress")])
def test_who_lies_in_a_mattress_is_found_out(height, why):
    bed = box((-0.7, 0.0, -1.0), (0.7, 0.5, 1.0))
    surface, _ = sample_surface(bed, 8000, seed=0)
    lying = clip(30, root=(0.0, height, 0.0), pose=(("pelvis", -90),), label="lie")
    piece = sits.Furnishing(0, surface, [])
    assert sits.sunk(lying, piece, (0.0, 0.0, 0.0), 0.5) == why


def jogging(count, phase, speed, labels):
    """Legs that swing to and fro, in phase, at a speed m/s for each frame."""
    made = clip(count, label="run")
    swing = np.sin(2 * np.pi * (np.arange(count) + phase) / 20)
    for side, sign in (("left", 1), ("right", -1)):
        angle = np.radians(25) * swing * sign * (speed > 0)
        made.rotations[:, JOINTS[f"{side}_hip"]] = np.stack(
            [np.cos(angle / 2), np.sin(angle / 2), 0 * angle, 0 * angle], -1
        )
    root = made.root.copy()
    root[:, 2] = np.cumsum(speed) / FPS
    return replace(made, root=root, labels=np.array(labels))


def test_runs_are_joined_from_a_stand_to_a_stand():
    still, quick = ["idle"] * 15, ["run"] * 45
    start = jogging(60, 5, np.clip((np.arange(60) - 14) / 10, 0, 1) * 2.5, still + quick)
    through = jogging(50, 0, np.full(50, 2.5), ["run"] * 50)
    stop = jogging(60, 0, np.clip((50 - np.arange(60)) / 10, 0, 1) * 2.5, quick + still)
    composer = RunComposer([start, through, replace(through, name="02_01"), stop], seed=0)
    runs = [run for run in (composer.compose() for _ in range(12)) if run is not None]
    assert len(runs) >= 6 and sum(composer.report.values()) == 12
    for run in runs:
        assert run.labels[0] == run.labels[-1] == "idle" and (run.labels == "run").sum() > 25
        assert np.linalg.norm(np.diff(run.root, axis=0), axis=-1).max() * FPS < 4.0, "no jump at a join"


def captured_sit(count=160):
    """Walks up along -Z, turned to face +Z by then, sits down on a seat of 0.45 m, and stays."""
    made = clip(count, label="walk", pose=())
    down, seated = 80, 100
    sink = np.clip((np.arange(count) - down) / (seated - down), 0, 1)
    root = made.root.copy()
    root[:, 1] = 0.93 - sink * (0.93 - 0.45 - SEAT_TO_PELVIS)
    root[:, 2] = 1.5 * np.clip(1 - np.arange(count) / down, 0, 1) + 0.2 * (1 - sink)
    bend = np.radians(85) * sink
    for side in ("left", "right"):
        for name, sign in (("hip", -1), ("knee", 1)):
            made.rotations[:, JOINTS[f"{side}_{name}"]] = np.stack(
                [np.cos(bend / 2), sign * np.sin(bend / 2), 0 * bend, 0 * bend], -1
            )
    labels = np.array(["walk"] * down + ["sit_down"] * (seated - down) + ["sit"] * (count - seated))
    return replace(made, root=root, labels=labels)


@pytest.mark.parametrize("plain", [True, False])
def test_a_captured_sit_is_carried_to_a_piece_of_its_height(plain):
    (event,) = events.sit_events(captured_sit())
    goal = Goal(np.array([0.0, 0.45 + SEAT_TO_PELVIS, 0.0]), np.array([0.0, 0, 1]))
    seat = box((-0.3, 0.4, -0.4), (0.3, 0.45, 0.1))
    fits = sits.Furnishing(0, sample_surface(seat, 6000, seed=0)[0], [goal])
    high = replace(goal, position=goal.position + [0, 0.3, 0])
    too_high = sits.Furnishing(1, sample_surface(seat + [0, 0.3, 0], 6000, seed=0)[0], [high])
    walks = WalkIndex([clip(60, velocity=(0, 0, 1.0))])
    composer = sits.Composer([fits, too_high], walks, seed=0, plain=plain)
    made = [composer.compose(event) for _ in range(8)]
    kept = [one for one in made if one is not None]
    assert len(kept) == composer.report["kept"] >= 4, composer.report
    for one in kept:
        assert one.piece == 0 and one.labels[-1] == "sit"
        assert np.allclose(one.goal[-1, :3], one.root[-1], atol=0.03), "the goal is where the pelvis sits"
    lengths = {len(one) for one in kept}
    assert (len(lengths) == 1) == plain, "only augmented ones differ in pace"
