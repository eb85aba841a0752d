"""The sets of motion capture that MotionNet learns from: which clips, how much of each, and what is chained of them."""
