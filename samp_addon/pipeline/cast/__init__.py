"""Several characters in one scene: a place for each of them, and takes that keep clear of each other."""
