"""Motions as Actions: keyframes, notes in custom properties, and refinement of an Action."""
