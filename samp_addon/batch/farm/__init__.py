"""Many jobs in pieces for render farms and clusters: which lines a piece has, and what becomes of the reports."""
