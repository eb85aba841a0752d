"""Training and evaluation of the long-term method."""
