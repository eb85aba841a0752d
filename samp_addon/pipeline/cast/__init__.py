"""Several characters in one scene: places for all of them, takes that keep clear of each other, and when each starts."""
