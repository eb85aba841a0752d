"""Training stages: prior, PointNet, sub-goal bodies, routes, poses, and the networks of the paper's table 1."""
