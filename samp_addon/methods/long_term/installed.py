"""Whether the trained weights are there. Light: the registry asks when Blender starts."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parents[3] / "models" / "weights"
WEIGHTS = ("long_term_prior", "long_term_sub_goal", "long_term_route", "long_term_pose")


def installed(folder: Path | None = None) -> bool:
    """Return whether all weights are in a folder, that of the shipped ones if left out."""
    return all(((folder or FOLDER) / f"{name}.safetensors").exists() for name in WEIGHTS)
