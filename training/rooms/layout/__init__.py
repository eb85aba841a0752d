"""Layouts: rooms with walls, doors and windows, furnished with training pieces or held-out ones."""
