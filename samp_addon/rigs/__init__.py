"""Rigs other than SMPL-X: which bone is which joint, and takes retargeted to them."""
