"""A take carried to a body of other proportions: its hips, its seat, its footprints."""
