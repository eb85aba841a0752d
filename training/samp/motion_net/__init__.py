"""Training of MotionNet (section 3.4): command lines, schedule, export. `learning` has the training itself."""
