"""Composed sits and lies fitted to the piece of furniture they stand on (issue: bodies that fit the furniture)."""
