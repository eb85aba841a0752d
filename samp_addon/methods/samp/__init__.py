"""SAMP (papers/samp.txt): a goal on the object, a path to it, and the motion frame by frame."""
