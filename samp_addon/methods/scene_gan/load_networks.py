"""The trained networks of Scene GAN, loaded once for each version of their weights."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING

from ... import dependencies
from ...errors import SampError

if TYPE_CHECKING:
    from ....models.scene_gan.networks import SceneGan

NAME = "scene_gan"
FOLDER = Path(__file__).resolve().parents[3] / "models" / "weights"


def installed(folder: Path | None = None) -> bool:
    """Return whether the weights are there. Imports no torch."""
    return ((folder or FOLDER) / f"{NAME}.safetensors").exists()


def trained(folder: Path | None = None) -> SceneGan:
    """Return the trained networks; shared, do not modify. Raises SampError for missing or damaged weights."""
    dependencies.load_torch()
    from ....models import weights

    try:
        return _networks(folder, weights.file_version(NAME, folder))
    except weights.WeightsError as error:
        raise SampError(str(error)) from error


@functools.lru_cache(maxsize=2)
def _networks(folder: Path | None, version: tuple[str, int, str]) -> SceneGan:
    """version: of the file, which only has to differ between contents."""
    import torch

    from ....models.scene_gan import networks

    with torch.inference_mode(False):
        return networks.load(folder)
