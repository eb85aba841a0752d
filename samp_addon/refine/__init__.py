"""Refinement of motions: foot lock, inverse kinematics, and the optimisation of a whole take against its scene."""
