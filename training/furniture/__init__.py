"""Furniture for training and evaluation: procedural pieces, and real ones with a fixed held-out split."""

from .generate import CATEGORIES, generate, unseen
from .library import available, is_held_out, load, missing, read_glb
from .piece import Piece

__all__ = [
    "CATEGORIES",
    "Piece",
    "available",
    "generate",
    "is_held_out",
    "load",
    "missing",
    "read_glb",
    "unseen",
]
