"""Weights fit their network exactly, or one sentence names the file and the tensor."""

import pytest
import torch
from samp_blender.models import weights
from torch import nn


def without(name):
    return lambda tensors: {key: value for key, value in tensors.items() if key != name}


CASES = [
    (without("0.weight"), "'small.safetensors' lack the tensor '0.weight'"),
    (without("1.running_mean"), "'small.safetensors' lack the tensor '1.running_mean'"),
    (lambda tensors: tensors | {"extra": torch.ones(2)}, "'small.safetensors' hold a tensor 'extra'"),
    (lambda tensors: tensors | {"0.bias": torch.ones(4)}, r"'0.bias' .* has shape \(4,\) instead of \(3,\)"),
]


def small():
    return nn.Sequential(nn.Linear(2, 3), nn.BatchNorm1d(3))


@pytest.mark.parametrize(("changed", "words"), CASES, ids=["parameter", "buffer", "unexpected", "shape"])
def test_a_file_that_does_not_fit_is_refused(tmp_path, changed, words):
    path = weights.save_weights("small", changed(small().state_dict()), tmp_path)
    with pytest.raises(weights.WeightsError, match=words):
        weights.fill(small(), weights.load_weights("small", tmp_path), path)


def test_a_file_that_fits_is_copied(tmp_path):
    source, target = small(), small()
    path = weights.save_weights("small", source.half().state_dict(), tmp_path)
    weights.fill(target, weights.load_weights("small", tmp_path), path)
    assert target[0].weight.dtype == torch.float32
    assert torch.equal(target[0].weight, source[0].weight.float())


def test_the_version_of_a_file_changes_with_its_content(tmp_path):
    with pytest.raises(weights.WeightsError, match="missing"):
        weights.file_version("small", tmp_path)
    weights.save_weights("small", {"a": torch.zeros(2)}, tmp_path)
    first = weights.file_version("small", tmp_path)
    assert weights.file_version("small", tmp_path) == first
    weights.save_weights("small", {"a": torch.ones(2)}, tmp_path)
    assert weights.file_version("small", tmp_path) != first
