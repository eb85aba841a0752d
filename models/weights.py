"""Weights on disk: .safetensors only, each with a checksum beside it that finds a damaged file."""

from __future__ import annotations

import hashlib
from pathlib import Path

import torch

FOLDER = Path(__file__).parent / "weights"


class WeightsError(Exception):
    """A weights file that is missing or damaged; one sentence that says what to do."""


def weights_path(name: str) -> Path:
    """The file of a network's weights."""
    return FOLDER / f"{name}.safetensors"


def checksum(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def save_weights(name: str, tensors: dict[str, torch.Tensor], folder: Path = FOLDER) -> Path:
    """Writes tensors in half precision (integers as they are) and the checksum; returns the file's path."""
    from safetensors.torch import save_file

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.safetensors"
    half = {k: (v.half() if v.is_floating_point() else v).contiguous().cpu() for k, v in tensors.items()}
    save_file(half, path)
    path.with_suffix(".sha256").write_text(checksum(path) + "\n")
    return path


def load_weights(name: str, folder: Path = FOLDER) -> dict[str, torch.Tensor]:
    """Tensors by name, as they were saved. Raises WeightsError for a missing or damaged file."""
    path = folder / f"{name}.safetensors"
    expected = path.with_suffix(".sha256")
    if not path.exists() or not expected.exists():
        raise WeightsError(f"The weights '{path.name}' are missing; install the add-on again.")
    if checksum(path) != expected.read_text().strip():
        raise WeightsError(f"The weights '{path.name}' are damaged; install the add-on again.")
    from safetensors.torch import load_file

    return load_file(path)
