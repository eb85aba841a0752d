"""The file of the pieces next to a fitted training set: names, categories and triangles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .pieces import FittingPiece


def beside(path: Path) -> Path:
    """Return the path of the file of pieces of a training set."""
    return Path(path).with_suffix(".pieces.npz")


def write_pieces(path: Path, pieces: list[FittingPiece]) -> None:
    """Write the pieces beside a training set ``path``."""
    np.savez_compressed(
        beside(path),
        names=np.array([piece.name for piece in pieces]),
        categories=np.array([piece.category for piece in pieces]),
        counts=np.array([len(piece.triangles) for piece in pieces]),
        triangles=np.concatenate([piece.triangles for piece in pieces]).astype(np.float32),
    )


def read_pieces(path: Path) -> list[FittingPiece]:
    """Read the pieces beside a training set ``path``, in the order of its indices."""
    with np.load(beside(path)) as file:
        parts = np.split(file["triangles"], np.cumsum(file["counts"])[:-1])
        named = zip(file["names"], file["categories"], parts, strict=True)
        return [FittingPiece(k, str(c), str(n), t.astype(np.float64)) for k, (n, c, t) in enumerate(named)]
