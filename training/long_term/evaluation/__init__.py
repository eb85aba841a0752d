"""Tables of the long-term paper on test rooms, and baselines."""
