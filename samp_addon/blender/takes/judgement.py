"""Whether a take is good, doubtful or bad, and why, from the notes on its Action.

The panel calls this at every redraw: import nothing heavy here.
"""

from __future__ import annotations

from typing import Literal

import bpy

from ..actions import notes

Verdict = Literal["GOOD", "DOUBTFUL", "BAD", "UNKNOWN"]

WARNINGS_KEY = "samp_warnings"
"""Custom property of an Action: sentences on what is wrong with the take, one a line."""

LIMITS = (
    ("position_error_cm", 10.0, 20.0, "The take ends {:.0f} cm from its goal."),
    ("rotation_error_deg", 30.0, 60.0, "It faces {:.0f} degrees away from its goal."),
    ("penetration_max_cm", 5.0, 10.0, "The body is {:.0f} cm deep in the scene somewhere."),
    ("stance_slide_cm_s", 10.0, 20.0, "Standing feet slide at {:.0f} cm/s."),
)
"""Measure, the value above which a take is doubtful, the one above which it is bad, and the sentence."""


def judge(action: bpy.types.Action) -> tuple[Verdict, str]:
    """Return the verdict on a take and the reason: its warnings and the measures beyond their limits."""
    numbers, verdict = notes.read_measures(action), "GOOD"
    reasons = [line for line in str(action.get(WARNINGS_KEY, "")).splitlines() if line.strip()]
    if not numbers and not reasons:
        return "UNKNOWN", "It has not been measured."
    if reasons:
        verdict = "DOUBTFUL"
    for key, doubtful, bad, sentence in LIMITS:
        value = numbers.get(key, 0.0)
        if value > doubtful:
            reasons.append(sentence.format(value))  # as guards.py warns of it
            verdict = "BAD" if value > bad or verdict == "BAD" else "DOUBTFUL"
    return verdict, "\n".join(dict.fromkeys(reasons)) or "No fault was found."
