"""Furnished rooms with people: the training corpus of all three methods."""
