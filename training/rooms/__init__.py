"""Furnished rooms with people in them: the corpus that all three methods learn from."""
