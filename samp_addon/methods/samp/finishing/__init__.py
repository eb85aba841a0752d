"""Finishing of raw rollouts: the end on the goal, limbs out of the furniture, locked feet, floor heights."""
