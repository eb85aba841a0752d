"""Rigs other than SMPL-X: read them, map their bones and carry takes to them."""
