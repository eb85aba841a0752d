"""Training steps of MotionNet (section 3.4): frames resident on the device, rollouts, loss and optimiser."""
