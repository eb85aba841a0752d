"""The rollout with the shipped weights: the same seed, a real sit, limits, cancelling, damaged weights."""

import numpy as np
import pytest
from samp_blender.models import weights
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.evaluation import metrics
from samp_blender.samp_addon.methods.samp.request import Request
from samp_blender.samp_addon.methods.samp.rollout import generator, tracking
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.seats.seats import find_goals
from shapes import box

CHAIR = np.concatenate(
    [box((-0.25, 0.0, -0.25), (0.25, 0.43, 0.2)), box((-0.25, 0.43, -0.25), (0.25, 0.9, -0.2))]
)


def sit(seed, start=(0.6, 0.0, 2.2), yaw=0.4):
    goal = find_goals(CHAIR, "sit", floor_height=0.0)[0]
    return Request(
        np.array(start),
        yaw,
        "sit",
        goal,
        np.array([start, [0.0, 0.0, 0.8]]),
        CHAIR,
        0.0,
        seed=seed,
        hold_seconds=1.0,
    )


@pytest.fixture(scope="module")
def takes():
    return generator.generate([sit(seed) for seed in range(8)])


def test_most_takes_sit_on_their_goal(takes):
    good = [take for take in takes if isinstance(take, Motion)]
    assert len(good) >= 6, [str(take) for take in takes if not isinstance(take, Motion)]
    for take in good:
        goal = sit(0).goal
        assert metrics.position_error(take, goal) < 5 and metrics.rotation_error(take, goal) < 8
        assert 0 < take.interaction_start < len(take)
        assert np.isfinite(take.root).all() and np.isfinite(take.rotations).all()


def test_takes_are_near_their_goal_before_finishing_moves_them_onto_it():
    goal = sit(0).goal
    guided = generator.generate([sit(seed) for seed in range(8)], stage="guided")
    errors = [(metrics.position_error(take, goal), metrics.rotation_error(take, goal)) for take in guided]
    distance, turn = np.median(errors, axis=0)
    assert distance < 15 and turn < 15, errors
    assert sum(metrics.success(take, goal) for take in guided) >= 6, errors


def test_seated_characters_stand_up_and_walk_away(takes):
    good = [take for take in takes if isinstance(take, Motion)][:3]
    away = np.array([-1.2, 0.0, 2.4])
    requests = [
        Request(take.root[-1] * [1.0, 0.0, 1.0], 0.0, "walk", Goal(away, np.array([0.0, 0, 1]), "walk"),
                np.array([[0.0, 0, 0.75], away]), seed=k, hold_seconds=0.5, after=take)
        for k, take in enumerate(good)
    ]  # fmt: skip
    left = generator.generate(requests)
    arrived = [take for take in left if isinstance(take, Motion)]
    assert len(arrived) >= 2, [str(take) for take in left]
    for take in arrived:
        assert take.root[0, 1] < 0.7 and take.root[-15:, 1].min() > 0.8
        assert np.hypot(*(take.root[-1] - away)[[0, 2]]) < 0.2
        assert take.actions[-1].argmax() == 0


BED = np.concatenate([box((-0.8, 0, -1.0), (0.8, 0.48, 1.0)), box((-0.8, 0, -1.1), (0.8, 0.9, -1.0))])


def lies():
    """Return a goal on the bed and requests for six takes that lie down there."""
    goal = find_goals(BED, "lie", floor_height=0.0)[0]
    side = 1.0 if goal.position[0] >= 0 else -1.0
    start, bedside = np.array([side * 2.4, 0.0, 0.8]), np.array([side * 1.15, 0.0, goal.position[2]])
    way = np.array([start, bedside])
    return goal, [
        Request(start, -1.0, "lie", goal, way, BED, seed=seed, hold_seconds=1.0) for seed in range(6)
    ]


def test_most_takes_lie_down_on_their_goal():
    goal, requests = lies()
    takes = generator.generate(requests)
    good = [take for take in takes if isinstance(take, Motion)]
    assert len(good) >= 4, [str(take) for take in takes if not isinstance(take, Motion)]
    for take in good:
        assert metrics.position_error(take, goal) < 5 and metrics.rotation_error(take, goal) < 8
        joints, _ = take.forward_kinematics()
        last = joints[-1]
        assert np.ptp(last[[0, 12, 15], 1]) < 0.35, "pelvis, neck and head are nearly level"
        assert last[:, 1].min() > 0.4, "no limb hangs down to the floor"


def test_lies_are_near_their_goal_before_finishing_moves_them_onto_it():
    goal, requests = lies()
    guided = generator.generate(requests, stage="guided")
    errors = [(metrics.position_error(take, goal), metrics.rotation_error(take, goal)) for take in guided]
    distance, turn = np.median(errors, axis=0)
    assert distance < 30 and turn < 8, errors


def test_takes_of_different_seeds_differ(takes):
    good = [take for take in takes if isinstance(take, Motion)]
    count = min(len(good[0]), len(good[1]))
    assert np.abs(good[0].root[:count] - good[1].root[:count]).max() > 0.01


def test_the_same_seed_gives_the_same_take():
    first, again = generator.generate([sit(3)])[0], generator.generate([sit(3)])[0]
    if isinstance(first, Motion):
        assert np.array_equal(first.root, again.root) and np.array_equal(first.rotations, again.rotations)
    else:
        assert str(first) == str(again)


def test_stance_feet_stand_still(takes):
    take = next(take for take in takes if isinstance(take, Motion))
    assert metrics.measure(take, sit(0).goal)["stance_slide_cm_s"] < 5


def test_a_walk_ends_standing_on_its_place():
    goal = Goal(np.array([0.5, 0.0, 3.0]), frames.yaw_direction(0.0), "walk")
    results = generator.generate(
        [Request(np.zeros(3), 0.0, "walk", goal, np.zeros((0, 3)), seed=k) for k in range(4)]
    )
    good = [take for take in results if isinstance(take, Motion)]
    assert len(good) >= 3
    for take in good:
        assert np.linalg.norm((take.root[-1] - goal.position)[[0, 2]]) < 0.05
        assert take.interaction_start is None


def test_no_take_runs_forever(monkeypatch):
    """A goal that is never reached ends in an error, not in an endless rollout."""
    monkeypatch.setattr(tracking, "ARRIVED", -1.0)
    monkeypatch.setattr(tracking, "GRACE", 0.0)
    result = generator.generate([sit(0)])[0]
    assert isinstance(result, SampError) and "stuck" in str(result)


def test_cancelling_stops_the_rollout():
    class Stop(Exception):
        pass

    shares = []

    def progress(share):
        shares.append(share)
        if len(shares) == 3:
            raise Stop

    with pytest.raises(Stop):
        generator.generate([sit(0)], progress)
    assert len(shares) == 3


@pytest.mark.parametrize("action, words", [("dance", "no action")])
def test_unknown_actions_are_errors(action, words):
    result = generator.generate([Request(np.zeros(3), 0.0, action, Goal(np.ones(3), np.array([0, 0, 1.0])))])[
        0
    ]
    assert isinstance(result, SampError) and words in str(result)


def test_damaged_weights_are_detected(tmp_path):
    import torch

    path = weights.save_weights("thing", {"a": torch.arange(6.0)}, tmp_path)
    assert torch.equal(weights.load_weights("thing", tmp_path)["a"], torch.arange(6.0).half())
    body = bytearray(path.read_bytes())
    body[-1] ^= 1
    path.write_bytes(bytes(body))
    with pytest.raises(weights.WeightsError, match="damaged"):
        weights.load_weights("thing", tmp_path)
    with pytest.raises(weights.WeightsError, match="missing"):
        weights.load_weights("other", tmp_path)
