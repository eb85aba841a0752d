"""GoalNet: its shapes, labels and measures, and goals that always lie on the surface."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from samp_blender.models import goal_net, weights
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.evaluation import goal_samples as measures
from samp_blender.samp_addon.methods.samp import goals as sampling
from samp_blender.samp_addon.scene.seats import postures, seats
from samp_blender.samp_addon.scene.voxels import InteractionGrid
from samp_blender.training import furniture
from samp_blender.training.furniture import shapes
from samp_blender.training.samp.goal_net import dataset, train
from samp_blender.training.samp.goal_net.evaluate import evaluate, handed_out


@pytest.fixture(scope="module")
def sofa():
    return furniture.generate("sofa", np.random.default_rng(3)).triangles


def on_the_surface(triangles, goal):
    """The goal's height over the surface is the posture's, and the geometry's own test accepts it as it is."""
    snapped = seats.snap_goal(triangles, goal, reach=0.03)
    return snapped is not None and np.linalg.norm(snapped.position - goal.position) < 0.05


def test_the_network_has_the_papers_sizes():
    net = goal_net.GoalNet()
    sizes = [(m.in_features, m.out_features) for m in net.interaction_encoder if hasattr(m, "in_features")]
    assert sizes == [(2048, 512), (512, 512), (512, 64)]
    features, action, goal = torch.randn(5, 2048), torch.tensor([0, 1, 0, 1, 1]), torch.randn(5, 6)
    predicted, mean, log_variance = net(features, action, goal)
    assert predicted.shape == (5, 6) and mean.shape == log_variance.shape == (5, 3)


def test_the_loss_is_squared_error_and_half_the_divergence():
    goal = torch.tensor([[0.25, 0.0, 0.0, 0.0, 0.0, 1.0]])
    zero = torch.zeros(1, 3)
    assert goal_net.loss(goal, goal, zero, zero, 0.5) == 0
    off = goal + torch.tensor([[0.25, 0, 0, 0, 0, 0]])
    assert goal_net.loss(off, goal, zero, zero, 0.5) == pytest.approx(1.0)
    # KL of N(2, 1) from N(0, 1) is 2 in each of three dimensions.
    assert goal_net.loss(goal, goal, zero + 2, zero, 0.5) == pytest.approx(3.0)


@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_turned_labels_are_those_of_a_turned_grid(sofa, quarters):
    label = dataset.label(furniture.Piece("sofa", sofa, "a"), shapes.turned(sofa, 0.7))[0].turned(quarters)
    yaw = seats.infer_front_yaw(shapes.turned(sofa, 0.7)) - quarters * np.pi / 2
    grid = InteractionGrid.build(shapes.turned(sofa, 0.7), yaw)
    np.testing.assert_allclose(label.features(), grid.object_features(), atol=1e-6)
    goal = seats.find_goals(shapes.turned(sofa, 0.7), "sit")[0]
    local = shapes.turned((goal.position - grid.centre)[None, None], -yaw)[0, 0]
    facing = shapes.turned(goal.direction[None, None], -yaw)[0, 0]
    gaps = np.abs(label.goals - np.concatenate([local, facing])).max(axis=1)
    assert gaps.min() < 1e-6


def test_mirrored_labels_are_those_of_a_mirrored_object(sofa):
    label = dataset.label(furniture.Piece("sofa", sofa, "a"), sofa)[0].mirrored()
    grid = InteractionGrid.build(sofa * [-1, 1, 1], seats.infer_front_yaw(sofa))
    np.testing.assert_allclose(label.features(), grid.object_features(), atol=0.02)
    assert label.goals[:, 3:] @ [0, 0, 1] == pytest.approx(
        dataset.label(furniture.Piece("sofa", sofa, "a"), sofa)[0].goals[:, 5]
    )


def test_labels_are_the_same_for_any_number_of_workers(monkeypatch):
    monkeypatch.setattr(dataset, "real_pieces", lambda held_out: [])
    monkeypatch.setattr(furniture, "CATEGORIES", ("stool", "chair"))
    one, two = (dataset.training_objects(5, 0, 2, workers) for workers in (1, 2))
    assert len(one) == len(two) >= 3
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a.goals, b.goals)


def test_training_is_seeded_and_learns(sofa):
    objects = dataset.label(furniture.Piece("sofa", sofa, "a"), sofa) * 4
    first, second = (train.train(objects, seed=1, epochs=50) for _ in range(2))
    for a, b in zip(first.parameters(), second.parameters(), strict=True):
        assert torch.equal(a, b)
    untrained = evaluate(goal_net.GoalNet().eval(), objects)
    trained = evaluate(first, objects)
    assert trained["position_error_cm"] < 0.7 * untrained["position_error_cm"]


def test_drawn_goals_and_labels_are_compared_as_sets():
    labels = torch.zeros(1, 3, 6)
    labels[0, :, 5], labels[0, 1, 0], labels[0, 2, 0] = 1, 1.0, 0.5
    present = torch.tensor([[True, True, False]])
    assert goal_net.set_error(labels[:, :2].clone(), labels, present) == 0
    # All goals on one label: the other one is a metre away.
    one = labels[:, :1].repeat(1, 4, 1)
    unit = goal_net.POSITION_SCALE**2
    assert goal_net.set_error(one, labels, present).item() == pytest.approx(0.5 / unit, rel=1e-5)
    between = labels[:, [0, 1, 2]].clone()
    assert goal_net.set_error(between, labels, present).item() == pytest.approx(0.25 / 3 / unit, rel=1e-5)


def test_goals_drawn_from_the_prior_face_as_labels_do_with_their_term(sofa):
    objects = dataset.label(furniture.Piece("sofa", sofa, "a"), sofa) * 4
    off = [
        evaluate(train.train(objects, 1, 150, prior=prior), objects)["sample_to_label_deg"]
        for prior in (0.0, 1.0)
    ]
    assert off[1] < 0.7 * off[0]


def test_errors_are_in_centimetres_and_degrees():
    a = np.array([[0, 0, 0], [1.0, 0, 0]])
    assert measures.position_error(a, a + [0, 0.03, 0.04]) == pytest.approx(5.0)
    turned = np.array([[np.sin(0.1), 0, np.cos(0.1)]]) * 3
    assert measures.direction_error(turned, np.array([[0, 0, 1.0]])) == pytest.approx(np.degrees(0.1))


def test_diversity_is_the_mean_over_pairs_of_different_goals():
    # Three goals on a line, 1 m apart: distances 1, 1 and 2; and one object whose goals are all alike.
    line = np.array([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[5, 5, 5]] * 3], dtype=float)
    assert measures.apd_position(line) == pytest.approx(100 * (4 / 3) / 2)
    ways = np.array([[[0, 0, 1], [1, 0, 0], [0, 0, -1]]], dtype=float)
    assert measures.apd_direction(ways) == pytest.approx((90 + 90 + 180) / 3)


@pytest.mark.parametrize(
    ("category", "action"), [("sofa", "sit"), ("chair", "sit"), ("stool", "sit"), ("bed", "lie")]
)
def test_sampled_goals_stand_on_the_surface(category, action):
    piece = furniture.generate(category, np.random.default_rng(8)).triangles
    placed = shapes.turned(piece, 2.2) + [3.0, 0.4, -1.0]
    drawn = sampling.draw_goals(placed, action, 6, seed=4)
    assert len(drawn.goals) == 6 and drawn.by_geometry == 0
    for goal in drawn.goals:
        assert goal.action == action and goal.direction[1] == 0
        assert np.linalg.norm(goal.direction) == pytest.approx(1)
        assert on_the_surface(placed, goal)


def test_the_same_seed_gives_the_same_goals_and_more_goals_begin_with_the_same(sofa):
    some, again, more = (sampling.sample_goals(sofa, "sit", n, seed=2) for n in (2, 2, 4))
    np.testing.assert_array_equal([g.position for g in some], [g.position for g in again])
    np.testing.assert_array_equal([g.position for g in some], [g.position for g in more[:2]])
    other = sampling.sample_goals(sofa, "sit", 2, seed=3)
    assert not np.allclose(some[0].position, other[0].position)


def test_geometry_replaces_a_network_whose_samples_are_useless(sofa, monkeypatch):
    class Nonsense(goal_net.GoalNet):
        def decode(self, condition, z):
            return torch.tensor([[5.0, 0, 5.0, 0, 0, 1.0]])

    monkeypatch.setattr(sampling, "load_goal_net", lambda: Nonsense().eval())
    drawn = sampling.draw_goals(sofa, "sit", 3, seed=0)
    assert drawn.by_geometry == 3 and drawn.rejected > 3
    assert all(on_the_surface(sofa, goal) for goal in drawn.goals)


@pytest.mark.parametrize(
    ("triangles", "action", "words"),
    [
        (shapes.box((0, 0, 0), (0.4, 1.6, 0.4)), "sit", "no place to sit"),
        (shapes.box((0, 0, 0), (0.4, 0.45, 0.4)), "lie", "no place to lie"),
        (shapes.box((0, 0, 0), (0.4, 0.45, 0.4)), "walk", "not for 'walk'"),
    ],
    ids=["cupboard", "stool", "walk"],
)
def test_impossible_goals_are_errors(triangles, action, words):
    with pytest.raises(SampError, match=words):
        sampling.sample_goals(triangles, action)


def test_missing_and_damaged_weights_are_errors(tmp_path, monkeypatch, sofa):
    with pytest.raises(weights.WeightsError, match="missing"):
        weights.load_weights("goal_net", tmp_path)
    path = weights.save_weights("goal_net", goal_net.GoalNet().state_dict(), tmp_path)
    path.write_bytes(path.read_bytes()[:-1] + b"?")
    with pytest.raises(weights.WeightsError, match="damaged"):
        weights.load_weights("goal_net", tmp_path)
    monkeypatch.setattr(weights, "FOLDER", tmp_path)
    with pytest.raises(SampError, match="damaged"):
        sampling.sample_goals(sofa, "sit")


def test_half_precision_moves_goals_by_less_than_a_millimetre(tmp_path):
    net = goal_net.GoalNet().eval()
    weights.save_weights("n", net.state_dict(), tmp_path)
    again = goal_net.GoalNet().eval()
    again.load_state_dict({k: v.float() for k, v in weights.load_weights("n", tmp_path).items()})
    features, action, z = torch.rand(3, 2048) - 0.5, torch.tensor([0, 1, 0]), torch.randn(3, 3)
    with torch.no_grad():
        a, b = (n.decode(n.condition(features, action), z) for n in (net, again))
    assert (a - b)[:, :3].abs().max() < 1e-3


def test_the_seats_height_is_the_pelvis_less_the_bodys_flesh(sofa):
    seat = seats.find_seats(sofa, "sit")[0]
    assert seat.goal.position[1] - seat.surface == pytest.approx(postures.SEAT_TO_PELVIS, abs=1e-6)


def test_goals_handed_out_are_as_varied_as_what_the_geometry_allows():
    rng = np.random.default_rng(0)
    pieces = [furniture.generate(name, rng) for name in ("sofa", "bench", "table")]
    found = handed_out(pieces, "sit")
    assert found["objects"] >= 2
    assert 0.5 < found["apd_position_cm"] / found["apd_position_labels_cm"] < 2


def test_the_temperature_scales_what_is_drawn_for_its_action():
    torch.manual_seed(0)
    net = goal_net.GoalNet().eval()
    features, noise = torch.rand(1, 2048).expand(2, -1), torch.randn(1, goal_net.LATENT).expand(2, -1)
    condition = net.condition(features, torch.tensor([0, 1]))
    before = net.draw(condition, noise)
    assert torch.allclose(before, net.decode(condition, noise))
    net.temperature[1] = 0.0
    after = net.draw(condition, noise)
    assert torch.allclose(after[0], before[0])
    assert torch.allclose(after[1], net.decode(condition[1:], torch.zeros(1, goal_net.LATENT))[0])


def test_the_temperature_is_fitted_to_the_labels(sofa):
    objects = dataset.label(furniture.Piece("sofa", sofa, "a"), sofa)
    torch.manual_seed(0)
    net = goal_net.GoalNet().eval()
    train.fit_temperature(net, [one for one in objects if one.action == 0], seed=0)
    # Untrained, nothing scatters as widely as the labels; of lying nothing is known.
    assert net.temperature.tolist() == pytest.approx([train.TEMPERATURES[-1], 1.0])
