"""What data sets need of a take beside its motion: labels for each frame, and pictures with depth and objects."""
