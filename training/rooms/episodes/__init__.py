"""Episodes of walking, standing, sitting and lying, composed from captured clips along navmesh paths."""
