"""The baseline networks of the paper."""

import pytest
import torch
from samp_blender.models.baselines import NETWORKS, hidden_width
from samp_blender.models.motion_net import LATENT, OBJECT
from samp_blender.models.state import SIZE


@pytest.mark.parametrize("name, varies", [("motion_net", True), ("mlp", False), ("moe", False)])
def test_only_motion_net_depends_on_z(name, varies):
    torch.manual_seed(0)
    net = NETWORKS[name]().eval()
    x, features = torch.randn(3, SIZE), torch.rand(3, OBJECT)
    with torch.inference_mode():
        first, other = (net.step(x, features, torch.randn(3, LATENT)) for _ in range(2))
        mean, log_variance = net.encode(x, x, features)
    assert first.shape == (3, SIZE) and torch.isfinite(first).all()
    assert (not torch.equal(first, other)) == varies
    assert bool((mean != 0).any() or (log_variance != 0).any()) == varies


def test_the_mlp_is_four_layers_of_512():
    layers = NETWORKS["mlp"](512).decoder.layers
    assert [(layer.in_features, layer.out_features) for layer in layers] == [
        (SIZE + 256, 512), (512, 512), (512, 512), (512, SIZE)
    ]  # fmt: skip


@pytest.mark.parametrize("name", NETWORKS)
@pytest.mark.parametrize("hidden", [64, 512])
def test_hidden_width_from_weights(name, hidden):
    assert hidden_width(NETWORKS[name](hidden).state_dict()) == hidden
