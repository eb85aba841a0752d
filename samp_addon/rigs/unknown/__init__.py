"""Humanoids whose bone names say nothing."""
