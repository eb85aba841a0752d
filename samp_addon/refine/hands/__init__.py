"""Hands on places: where a palm is, and how arm and trunk bring it there. No Blender."""
