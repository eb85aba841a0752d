"""Panels, properties, preferences."""
