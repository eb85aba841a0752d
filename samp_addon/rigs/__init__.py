"""Other skeletons than SMPL-X: which of their bones is which joint, and a take carried over to them."""
