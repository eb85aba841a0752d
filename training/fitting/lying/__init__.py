"""Lies whose bodies fit their beds: on the back, on a side, half sitting."""
