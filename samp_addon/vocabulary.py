"""The names of actions and contacts, in the order of their columns. Light: the panel asks for them at every redraw."""

from __future__ import annotations

ACTIONS = ("idle", "walk", "run", "sit", "lie")
SEATED = ("sit", "lie")
"""The actions that rest the body on an object."""
CONTACTS = ("pelvis", "right_hand", "left_hand", "right_foot", "left_foot")
POSTURES = {
    "sit": ("upright", "lean_back", "hands_on_lap", "hands_on_armrests", "hands_on_table", "legs_crossed"),
    "lie": ("on_back", "on_side", "half_sitting"),
}
"""The postures of a rest, by action. Those that do not exclude each other may be combined."""
POSTURE_NAMES = tuple(name for names in POSTURES.values() for name in names)
"""Their order wherever postures are numbers."""
