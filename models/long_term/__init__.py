"""The networks of the long-term method (Wang et al. 2021): pose prior, PointNet, sub-goal bodies, routes, poses."""
