"""Postures of rests: what the artist may ask for, what is drawn, what needs a place, and that the network gets them."""

import numpy as np
import pytest
import torch
from samp_blender.models import motion_net
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.evaluation import rest_posture
from samp_blender.samp_addon.methods.method import Option
from samp_blender.samp_addon.methods.samp import load_networks, posture_places, postures, weights_file
from samp_blender.samp_addon.methods.samp.method import POSTURE, Samp
from samp_blender.samp_addon.methods.samp.request import Request
from samp_blender.samp_addon.methods.samp.rollout import generator
from samp_blender.samp_addon.methods.samp.rollout.planned_take import plan_takes, start_rollout
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.vocabulary import POSTURE_NAMES
from shapes import box

SEAT = [((-0.3, 0.38, -0.3), (0.3, 0.45, 0.3))]
BACK = [((-0.3, 0.45, -0.36), (0.3, 0.95, -0.3))]
ARM = [((0.3, 0.45, -0.3), (0.36, 0.66, 0.3))]
TABLE = [((-0.6, 0.7, 0.3), (0.6, 0.74, 1.0))]
WALL = [((-2.0, 0.0, -0.5), (2.0, 2.5, -0.4))]
LOUNGER = [((-0.3, 0.45, -0.9), (0.3, 0.95, -0.5))]


@pytest.mark.parametrize(
    "text, names",
    [
        (None, ()),
        ("", ()),
        ("Lean Back", ("lean_back",)),
        ("hands_on_lap, legs_crossed", ("hands_on_lap", "legs_crossed")),
        ("lean_back,on_side", ("lean_back", "on_side")),
    ],
)
def test_parse(text, names):
    assert postures.parse(text) == names


@pytest.mark.parametrize(
    "text, message",
    [
        ("slouch", "no posture 'slouch'; choose of upright"),
        ("upright,lean_back", "cannot be upright and lean_back at once"),
        ("on_back,half_sitting", "cannot be on_back and half_sitting"),
    ],
)
def test_postures_that_nobody_can_have(text, message):
    with pytest.raises(UsageError, match=message):
        postures.parse(text)
    with pytest.raises(UsageError, match=message):
        Samp().check(Step("sit", "Chair", settings={"posture": text}))


@pytest.mark.parametrize(
    "boxes, places",
    [
        (SEAT, set()),
        (SEAT + BACK, {"lean_back"}),
        (SEAT + WALL, {"half_sitting"}),
        (SEAT + ARM, {"hands_on_armrests"}),
        (SEAT + TABLE, {"hands_on_table"}),
        (SEAT + LOUNGER, {"half_sitting"}),
        ([], set()),
    ],
)
@pytest.mark.parametrize("yaw", [0.0, 2.2])
def test_places_around_a_goal(boxes, places, yaw):
    solid = np.concatenate([box(*corners) for corners in boxes]) if boxes else np.zeros((0, 3, 3))
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    goal = Goal(np.array([1.0, 0.53, 2.0]), turn @ [0.0, 0.0, 1.0], "sit")
    found = set(posture_places.around(solid @ turn.T + [1.0, 0.0, 2.0], goal))
    assert found - {"half_sitting"} == places - {"half_sitting"}
    assert ("half_sitting" in found) >= ("half_sitting" in places)


BED = ((-0.8, 0.0, -1.0), (0.8, 0.5, 1.0))
HEADBOARD = ((-0.8, 0.0, -1.06), (0.8, 1.0, -1.0))


@pytest.mark.parametrize("edge, there", [(0.3, True), (0.45, True), (0.8, False)])
@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_wrists_on_a_table(edge, there, yaw):
    boxes = [*SEAT, ((-0.6, 0.7, edge), (0.6, 0.74, edge + 0.7))]
    turn = lambda points: rotation.rotate(rotation.about_y(np.array(yaw)), points)
    triangles = turn(np.concatenate([box(*one) for one in boxes]))
    goal = Goal(np.array([0.0, 0.53, 0.0]), turn(np.array([0.0, 0.0, 1.0])), "sit")
    wrists = posture_places.table(triangles, goal)
    assert (wrists is not None) == there
    if there:
        at = min(max(edge + posture_places.FROM_EDGE, posture_places.NEAREST), posture_places.ARMS_LENGTH)
        level = 0.74 + posture_places.WRIST
        wanted = [[posture_places.WRISTS, level, at], [-posture_places.WRISTS, level, at]]
        assert wrists == pytest.approx(turn(np.array(wanted)), abs=0.02)


@pytest.mark.parametrize(
    ("boxes", "posture", "behind"),
    [
        ([BED, HEADBOARD], ("half_sitting",), (0.3, 0.6)),
        ([BED, HEADBOARD], ("on_back",), (1.0, 1.0)),
        ([BED], ("half_sitting",), (1.0, 1.0)),  # no headboard: the place stays
    ],
)
@pytest.mark.parametrize("yaw", [0.0, 2.2])
def test_who_is_to_half_sit_lies_at_the_headboard(boxes, posture, behind, yaw):
    turn = rotation.quaternion_to_matrix(rotation.about_y(yaw))
    solid = np.concatenate([box(*corners) for corners in boxes]) @ turn.T
    goal = Goal(turn @ [0.1, 0.58, 0.0], turn @ [0.0, 0.0, 1.0], "lie")
    place = turn.T @ posture_places.suited(solid, goal, posture).position
    assert place[:2] == pytest.approx([0.1, 0.58])
    assert behind[0] - 1e-9 <= place[2] + 1.0 <= behind[1] + 1e-9


SHARES = [(("lean_back",), 0.6), (("upright", "hands_on_lap"), 0.3), (("on_side",), 0.1), ((), 0.0)]


@pytest.mark.parametrize(
    "action, places, possible",
    [
        ("sit", ["lean_back"], {("lean_back",), ("upright", "hands_on_lap")}),
        ("sit", [], {("upright", "hands_on_lap")}),
        ("lie", [], {("on_side",)}),
        ("walk", [], {()}),
    ],
)
def test_what_is_drawn(action, places, possible):
    draws = [postures.drawn(SHARES, action, places, seed) for seed in range(300)]
    assert set(draws) == possible
    assert draws == [postures.drawn(SHARES, action, places, seed) for seed in range(300)]
    if len(possible) == 2:
        assert 0.55 < np.mean([names == ("lean_back",) for names in draws]) < 0.78


def test_bodies_lean_on_a_back_as_often_as_people_on_seats_with_one():
    shares = [(("lean_back",), 0.2), (("upright",), 0.8)]
    draws = [postures.drawn(shares, "sit", ["lean_back"], seed) for seed in range(1000)]
    leaning = np.mean(["lean_back" in names for names in draws])
    assert leaning == pytest.approx(postures.WHERE_THERE_IS_PLACE["lean_back"], abs=0.05)


@pytest.mark.parametrize(
    "wanted, drawn",
    [
        (["hands_on_lap"], {("upright", "hands_on_lap")}),  # the trunk is drawn
        (["lean_back"], {("lean_back",)}),  # also where there is nothing to lean on
        (["legs_crossed"], {("legs_crossed",)}),  # no combination has it
    ],
)
def test_what_is_left_open_is_drawn(wanted, drawn):
    assert {postures.drawn(SHARES, "sit", [], seed, wanted) for seed in range(40)} == drawn


def network():
    """Return an untrained network that knows postures, all of them leaning back in its data."""
    torch.manual_seed(0)
    net = motion_net.MotionNet(32, motion_net.POSTURES)
    net.posture_rows[0, POSTURE_NAMES.index("lean_back")] = 1
    net.posture_shares[0] = 1
    rest = torch.zeros(1, 22, 4)
    rest[..., 0] = 1
    return load_networks.MotionNetwork(net.eval(), torch.tensor([0.93]), rest)


def test_the_network_gets_the_posture_on_the_way_to_the_rest():
    goal = Goal(np.array([0.0, 0.53, 0.0]), np.array([0.0, 0.0, 1.0]), "sit")
    chair = np.concatenate([box(*corners) for corners in SEAT + BACK])
    start, way = np.array([0.0, 0.0, 2.0]), np.array([[0.0, 0.0, 2.0], [0.0, 0.0, 0.8]])
    of = lambda **more: Request(start, 0.0, "sit", goal, way, chair, **more)
    requests = [of(posture=("hands_on_lap",)), of(posture_places=lambda: ("lean_back",)), of()]
    run = start_rollout(plan_takes(requests, network().net), network())
    assert [[POSTURE_NAMES[k] for k in torch.nonzero(row)[:, 0]] for row in run.postures] == [
        ["hands_on_lap"], ["lean_back"], [],
    ]  # fmt: skip
    sitting = torch.tensor([[0.0, 0.53, 0.0, 0.0, 0.0, 1.0, 0, 0, 0, 1, 0]]).repeat(3, 1)
    walking = sitting.clone()
    walking[:, 7], walking[:, 9] = 1, 0
    run.set_goals(sitting)
    assert run._object()[:, motion_net.OBJECT :].sum() == 2
    run.set_goals(walking)
    assert run._object().sum() == 0, "a walk leads to no rest"
    part = run.select(torch.tensor([1]))
    assert torch.equal(part.postures, run.postures[1:2])
    run.set_goals(sitting)
    assert run.step().pelvis.isfinite().all()


@pytest.mark.parametrize("content", [b"", b"\xff" * 40, b"\x02\0\0\0\0\0\0\0{}"])
def test_weights_without_postures_offer_none(tmp_path, content):
    assert not weights_file.knows_postures(tmp_path / "missing")
    file = tmp_path / "motion_net.safetensors"
    file.write_bytes(content)
    assert not weights_file.knows_postures(file)


def test_weights_with_postures_offer_them(tmp_path, monkeypatch):
    from safetensors.torch import save_file

    save_file({"posture_rows": torch.zeros(2, 9)}, tmp_path / "motion_net.safetensors")
    monkeypatch.setattr(weights_file.knows_postures, "__defaults__", (tmp_path / "motion_net.safetensors",))
    assert Samp().options == (POSTURE,) and isinstance(POSTURE, Option)


@pytest.mark.parametrize(
    "posture",
    [
        ("lean_back", "hands_on_armrests"),
        ("lean_back", "hands_on_lap", "legs_crossed"),
        ("upright", "hands_on_lap"),
    ],
)
def test_a_take_ends_in_the_posture_that_was_asked_for(posture):
    parts = SEAT + BACK + ARM + [((-0.36, 0.45, -0.3), (-0.3, 0.66, 0.3))]
    chair = np.concatenate([box(*corners) for corners in parts])
    goal = Goal(np.array([0.0, 0.63, -0.1]), np.array([0.0, 0.0, 1.0]), "sit")
    start, way = np.array([0.0, 0.0, 1.8]), np.array([[0.0, 0.0, 1.8], [0.0, 0.0, 0.7]])
    requests = [Request(start, np.pi, "sit", goal, way, chair, seed=k, posture=posture) for k in range(1, 5)]
    found = [rest_posture.flags(motion, "sit") for motion in generator.generate(requests)]
    reached = [{name for name in posture if flags[name][-1]} for flags in found]
    assert sum(names == set(posture) for names in reached) >= 3, reached
