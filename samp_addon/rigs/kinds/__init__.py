"""Bone names of published rigs."""
