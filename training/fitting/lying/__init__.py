"""Lies fitted to their beds: supine, on a side, half sitting."""
