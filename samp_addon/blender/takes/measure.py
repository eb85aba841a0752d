"""Measures of a finished take against the scene as it is now."""

from __future__ import annotations

import json

import bpy
import numpy as np

from ...evaluation import feet, metrics
from ...evaluation.obstacles import Obstacles
from ...motion import Motion
from ..actions import keyframes, notes
from ..character import character, characters
from ..scene import read_scene
from . import seen

TEXT = "SAMP measures"
"""Name of the text block that holds the last measures."""


def measure_take(context: bpy.types.Context, name: str = "", action_name: str = "") -> tuple[str, dict]:
    """Return name and measures of a character's Action, by default the active one.

    Raise SampError where there is no such character or Action.
    """
    owner, action = keyframes.find_action(context, name, action_name)
    motion, _ = seen.shown_motion(context, owner, action)
    people = characters.people(context)
    triangles = read_scene.read_scene(context, people).triangles
    return action.name, metrics.measure(
        motion, notes.read_goal(action), Obstacles(triangles), _floor(motion), character.body_of(owner)
    )


def write_text(name: str, numbers: dict) -> bpy.types.Text:
    """Write measures to the text block TEXT, replacing its content, and return it."""
    text = bpy.data.texts.get(TEXT) or bpy.data.texts.new(TEXT)
    text.from_string(json.dumps({"action": name, "metrics": numbers}, indent=1) + "\n")
    return text


def sentence(name: str, numbers: dict, text: str) -> str:
    """Return a summary of the main measures. text: name of the text block that holds all of them."""
    parts = []
    if "position_error_cm" in numbers:
        distance, angle = numbers["position_error_cm"], numbers["rotation_error_deg"]
        parts.append(f"{distance:.1f} cm and {angle:.0f} deg from the goal")
    parts.append(f"foot slide {numbers['foot_slide_cm_s']:.1f} cm/s")
    parts.append(f"deepest penetration {numbers['penetration_max_cm']:.1f} cm")
    return f"'{name}': {', '.join(parts)}; all measures are in the text '{text}'."


def _floor(motion: Motion) -> float:
    """Return the median height (metres) of the lower sole, which is on the floor most of the time."""
    return float(np.median(feet.sole_tracks(motion)[1].min(1)) / 100)
