"""Long-term motion between sub-goals (Wang et al. 2021): bodies, routes, poses, joined to one take."""
