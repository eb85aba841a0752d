"""Layouts: rooms with walls, doors and windows, furnished from the training pieces or from the held-out ones."""
