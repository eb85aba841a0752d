"""Geometry for fitting: pieces, seat surfaces, mutual penetration, probe points of the body, and pose edits."""
