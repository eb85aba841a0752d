"""Edits of takes that need more of the scene than the take: hands on objects, new ends, strips, markers, trails."""
