"""Loading the networks: only from files that fit, without side effects, and again when a file is replaced."""

import numpy as np
import pytest
import shapes
import torch
from samp_blender.models import goal_net, weights
from samp_blender.models.motion_net import ENCODER, MotionNet
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.methods.samp import goals
from samp_blender.samp_addon.methods.samp.load_networks import load_goal_net, load_motion_net
from samp_blender.samp_addon.methods.start_poses import hands_hang
from samp_blender.samp_addon.scene.voxels import InteractionGrid


def motion_tensors(seed=0):
    """What training/samp/motion_net/export.py writes, of a small network."""
    torch.manual_seed(seed)
    own = MotionNet(8).state_dict()
    shipped = {name: tensor for name, tensor in own.items() if not name.startswith(ENCODER)}
    return shipped | {"start_heights": torch.ones(2), "start_rotations": torch.zeros(2, 22, 4)}


def goal_tensors(seed=0):
    torch.manual_seed(seed)
    return goal_net.GoalNet().state_dict()


NETWORKS = [("motion_net", motion_tensors, load_motion_net), ("goal_net", goal_tensors, load_goal_net)]
LOST = [
    *[("motion_net", name) for name in ("start_heights", "start_rotations", "decoder.layers.0.bias")],
    *[("motion_net", name) for name in ("decoder.gate.0.weight", "input_mean", "object_std")],
    *[("goal_net", name) for name in ("temperature", "encoder.0.bias", "decoder.4.weight")],
]


@pytest.mark.parametrize(("network", "lost"), LOST)
def test_a_missing_tensor_is_one_sentence_that_names_it(tmp_path, network, lost):
    tensors, load = next((make(), load) for name, make, load in NETWORKS if name == network)
    del tensors[lost]
    weights.save_weights(network, tensors, tmp_path)
    with pytest.raises(SampError, match=f"'{network}.safetensors' lack the tensor '{lost}'"):
        load(tmp_path)


@pytest.mark.parametrize(("network", "make", "load"), NETWORKS, ids=["motion_net", "goal_net"])
def test_an_unexpected_tensor_is_one_sentence_that_names_it(tmp_path, network, make, load):
    weights.save_weights(network, make() | {"stranger": torch.zeros(1)}, tmp_path)
    with pytest.raises(SampError, match=f"'{network}.safetensors' hold a tensor 'stranger'"):
        load(tmp_path)


@pytest.mark.parametrize(("network", "make", "load"), NETWORKS, ids=["motion_net", "goal_net"])
@pytest.mark.parametrize("mode", [torch.no_grad, torch.enable_grad, torch.inference_mode])
def test_loading_leaves_gradients_as_they_are(tmp_path, network, make, load, mode):
    weights.save_weights(network, make(), tmp_path)
    with mode():
        before = torch.is_grad_enabled(), torch.is_inference_mode_enabled()
        loaded = load(tmp_path)
        assert (torch.is_grad_enabled(), torch.is_inference_mode_enabled()) == before
    net = loaded if network == "goal_net" else loaded.net
    assert not net.training and not any(parameter.is_inference() for parameter in net.parameters())


@pytest.mark.parametrize(("stored", "held"), [({}, 0), ({"held": torch.tensor(16)}, 16)])
def test_weights_without_the_count_of_held_components_hold_none(tmp_path, stored, held):
    tensors = motion_tensors()
    del tensors["held"]
    weights.save_weights("motion_net", tensors | stored, tmp_path)
    assert int(load_motion_net(tmp_path).net.held) == held


@pytest.mark.parametrize(("network", "make", "load"), NETWORKS, ids=["motion_net", "goal_net"])
def test_a_replaced_file_is_loaded_again(tmp_path, network, make, load):
    weights.save_weights(network, make(seed=1), tmp_path)
    first = load(tmp_path)
    assert load(tmp_path) is first
    weights.save_weights(network, make(seed=2), tmp_path)
    second = load(tmp_path)
    one, two = (loaded if network == "goal_net" else loaded.net for loaded in (first, second))
    different = zip(one.decoder.parameters(), two.decoder.parameters(), strict=True)
    assert any(not torch.equal(a, b) for a, b in different)


def test_no_part_of_the_shipped_motion_net_is_random():
    net = load_motion_net().net
    stored = weights.load_weights("motion_net")
    assert {name for name in stored if not name.startswith("start_")} | {
        "held",
        "goal_grid",
        "style_codes",
    } == set(net.state_dict())
    with pytest.raises(AttributeError):
        net.encode(torch.zeros(1, 647), torch.zeros(1, 647), torch.zeros(1, 2048))


def test_drawing_goals_leaves_gradients_on_between_two_goals():
    grid = InteractionGrid.build(shapes.box((0, 0, 0), (0.4, 0.45, 0.4)))
    drawn = goals._network_samples(grid, "sit", 2, 0)
    assert np.isfinite(next(drawn).position).all() and torch.is_grad_enabled()


def test_nobody_waits_with_raised_hands(tmp_path):
    """The shipped start poses; and of weights all of whose poses have raised hands, all."""
    shipped = load_motion_net().start_rotations.double().numpy()
    assert len(shipped) >= 6 and hands_hang(shipped).all()
    weights.save_weights("motion_net", motion_tensors(), tmp_path)
    assert len(load_motion_net(tmp_path).start_rotations) == 2
