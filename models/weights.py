"""Weights on disk: .safetensors files, each with a checksum next to it to detect damage."""

from __future__ import annotations

import hashlib
from pathlib import Path

import torch
from torch import nn

FOLDER = Path(__file__).parent / "weights"
_ADVICE = "export the weights again, or install the add-on again"


class WeightsError(Exception):
    """A weights file is missing, damaged or made for another network; the message is one sentence with a remedy."""


def weights_path(name: str, folder: Path | None = None) -> Path:
    """Return the path of a network's weights. folder: by default that of the shipped weights."""
    return (folder or FOLDER) / f"{name}.safetensors"


def checksum(path: Path) -> str:
    """Return the SHA-256 of a file, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def file_version(name: str, folder: Path | None = None) -> tuple[str, int, str]:
    """Return an identifier of the current content of a weights file, as a key for caches.

    It consists of the path, the modification time in nanoseconds and the stored checksum; the content is not read.
    Raise WeightsError for a missing file.
    """
    path = weights_path(name, folder)
    try:
        return str(path.resolve()), path.stat().st_mtime_ns, path.with_suffix(".sha256").read_text().strip()
    except OSError as error:
        raise WeightsError(f"The weights '{path.name}' are missing; install the add-on again.") from error


def save_weights(name: str, tensors: dict[str, torch.Tensor], folder: Path | None = None) -> Path:
    """Write tensors in half precision (integers unchanged) and their checksum; return the file's path."""
    from safetensors.torch import save_file

    path = weights_path(name, folder)
    path.parent.mkdir(parents=True, exist_ok=True)
    half = {k: (v.half() if v.is_floating_point() else v).contiguous().cpu() for k, v in tensors.items()}
    save_file(half, path)
    path.with_suffix(".sha256").write_text(checksum(path) + "\n")
    return path


def load_weights(name: str, folder: Path | None = None) -> dict[str, torch.Tensor]:
    """Return the saved tensors by name. Raise WeightsError for a missing or damaged file."""
    path = weights_path(name, folder)
    *_, expected = file_version(name, folder)
    if checksum(path) != expected:
        raise WeightsError(f"The weights '{path.name}' are damaged; install the add-on again.")
    from safetensors.torch import load_file

    return load_file(path)


def fill(module: nn.Module, tensors: dict[str, torch.Tensor], path: Path) -> None:
    """Copy tensors into all parameters and buffers of a module, converted to the precision of each.

    path: of the tensors' file, for the message. Raise WeightsError unless the tensors match the module exactly: one for
    each parameter and buffer, of the same shape, and no other.
    """
    expected = module.state_dict()
    for name, own in expected.items():
        if name not in tensors:
            raise missing_tensor(name, path)
        if tensors[name].shape != own.shape:
            raise WeightsError(
                f"The tensor '{name}' of the weights '{path.name}' has shape {tuple(tensors[name].shape)} instead of "
                f"{tuple(own.shape)}; {_ADVICE}."
            )
    for name in tensors:
        if name not in expected:
            raise WeightsError(
                f"The weights '{path.name}' hold a tensor '{name}' that the network does not have; {_ADVICE}."
            )
    module.load_state_dict(tensors)


def missing_tensor(name: str, path: Path) -> WeightsError:
    """Return the error for a tensor that a weights file lacks."""
    return WeightsError(f"The weights '{path.name}' lack the tensor '{name}'; {_ADVICE}.")
