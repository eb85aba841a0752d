"""Furniture for training and evaluation: procedural pieces, and the real ones with a fixed held-out split."""

from .generate import CATEGORIES, generate
from .library import is_held_out, load, read_glb
from .piece import Piece

__all__ = ["CATEGORIES", "Piece", "generate", "is_held_out", "load", "read_glb"]
