"""MotionNet's sizes against the paper's table S.3, and the equivalence of both ways of mixing experts."""

import pytest
import torch
from samp_blender.models.motion_net import EXPERTS, LATENT, ExpertLayer, MotionNet


def linear_sizes(module):
    return [(layer.in_features, layer.out_features) for layer in module if hasattr(layer, "in_features")]


@pytest.fixture(scope="module")
def net():
    torch.manual_seed(3)
    return MotionNet(512).eval()


@pytest.mark.parametrize(
    "part, sizes",
    [
        (lambda n: n.state_encoder, [(1294, 512), (512, 256), (256, 256)]),
        (lambda n: n.interaction_encoder, [(2048, 256), (256, 256), (256, 256)]),
        (lambda n: n.decoder.interaction_encoder, [(2048, 256), (256, 256), (256, 256)]),
        (lambda n: n.decoder.gate, [(64 + 647, 512), (512, 256), (256, 12)]),
    ],
)
def test_sizes_of_table_s3(net, part, sizes):
    assert linear_sizes(part(net)) == sizes


def test_prediction_network(net):
    shapes = [tuple(layer.weight.shape) for layer in net.decoder.layers]
    assert shapes == [(967, 12, 512), (576, 12, 512), (576, 12, 647)]
    assert (net.mean.out_features, net.log_variance.out_features, EXPERTS) == (LATENT, LATENT, 12)


def test_parameter_counts(net):
    count = lambda module: sum(p.numel() for p in module.parameters()) / 1e6
    assert count(net) == pytest.approx(16.71, abs=0.01)
    assert count(net.decoder) == pytest.approx(15.13, abs=0.01)


def test_mixing_outputs_equals_mixing_weights():
    torch.manual_seed(0)
    layer = ExpertLayer(40, 30).double()
    layer.bias.data.normal_()
    x, gate = torch.randn(7, 40).double(), torch.softmax(torch.randn(7, 12), -1).double()
    assert torch.allclose(layer(x, gate), layer.forward_mixed_weights(x, gate), atol=1e-12)


def test_step_is_the_same_for_both_ways_of_mixing(net):
    torch.manual_seed(1)
    x, features, z = torch.randn(3, 647), torch.rand(3, 2048), torch.randn(3, LATENT)
    with torch.inference_mode():
        assert torch.allclose(net.step(x, features, z), net.step(x, features, z, mix_weights=True), atol=1e-4)


def test_the_gate_selects_an_expert():
    layer = ExpertLayer(5, 4)
    gate = torch.eye(12)[[3]]
    x = torch.randn(1, 5)
    assert torch.allclose(layer(x, gate), x @ layer.weight[:, 3] + layer.bias[3], atol=1e-6)
