"""MotionNet's training data: sequences composed of real clips, their features, and the training itself."""
