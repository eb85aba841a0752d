"""Mending a Motion: foot lock, inverse kinematics, energies."""
