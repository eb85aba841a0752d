"""Fit composed sits and lies to their pieces of furniture."""
