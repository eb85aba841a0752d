"""The weights of an earlier training, from which another one begins."""

from __future__ import annotations

from pathlib import Path

import torch

from .....models import weights
from .....models.motion_net import MotionNet

OWN = ("posture_", "goal_grid", "style_")  # names of buffers that come from the new training data
OBJECT = (
    "object_",
    "interaction_encoder.",
    "decoder.interaction_encoder.",
)  # what depends on the object's grid


def load(net: MotionNet, path: Path) -> None:
    """Load averaged weights and normalisation: from a checkpoint, or from a folder of exported weights.

    The folder has encoder.safetensors and motion_net.safetensors; without the latter, the shipped weights are meant. A
    network from weights without postures ignores them at first, and one from weights with another kind of grid ignores
    the object. Raises WeightsError where the weights do not fit.
    """
    own = net.state_dict()
    tensors = {name: value for name, value in _tensors(path).items() if not name.startswith("start_")}
    kept = OWN
    if int(tensors.get("goal_grid", 0)) != int(own["goal_grid"]):
        kept = OWN + OBJECT
        for name in (f"{part}4.{kind}" for part in OBJECT[1:] for kind in ("weight", "bias")):
            own[name] = torch.zeros_like(own[name])
    tensors = {
        name: with_postures(name, value.to(own[name]), own[name].shape) if name in own else value
        for name, value in tensors.items()
        if not name.startswith(kept)
    }
    weights.fill(net, tensors | {name: value for name, value in own.items() if name.startswith(kept)}, path)


def _tensors(path: Path) -> dict[str, torch.Tensor]:
    if path.is_dir():
        own = path if weights.weights_path("motion_net", path).exists() else None
        return weights.load_weights("motion_net", own) | weights.load_weights("encoder", path)
    body = torch.load(path, map_location="cpu", weights_only=True)
    return {**body["net"], **body["average"]}


def with_postures(name: str, values: torch.Tensor, shape: torch.Size) -> torch.Tensor:
    """Return a tensor of weights that were trained without postures, extended to a shape.

    Postures come last among the inputs of a layer. They get the weight zero, the mean zero and the deviation one.
    """
    if values.shape == shape or values.dim() != len(shape):
        return values
    wider = [k for k, (a, b) in enumerate(zip(values.shape, shape, strict=True)) if a < b]
    if len(wider) != 1:
        return values
    axis, extra = wider[0], list(values.shape)
    extra[axis] = shape[axis] - values.shape[axis]
    return torch.cat([values, values.new_full(extra, 1.0 if name == "object_std" else 0.0)], axis)
