"""The names of actions and contacts, in the order of their columns. Light: the panel asks for them at every redraw."""

from __future__ import annotations

ACTIONS = ("idle", "walk", "run", "sit", "lie")
SEATED = ("sit", "lie")
"""The actions that rest the body on an object."""
CONTACTS = ("pelvis", "right_hand", "left_hand", "right_foot", "left_foot")
