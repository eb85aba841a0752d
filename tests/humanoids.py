"""Rigs for tests, by the name under which scripts outside of the repository import them."""

from samp_blender.tests.support.blender.humanoids import make, rigify

__all__ = ["make", "rigify"]
