"""Notes that a take's Action carries in custom properties: what keyframes cannot show.

The panel reads these at every redraw: import nothing heavy here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ... import frames
from ...motion import Goal, Motion

if TYPE_CHECKING:
    from ...refine.hands.palm import HandContact

MOTION_KEY = "samp"
"""Contacts, action weights and interaction start of the Motion; marks an Action as a take."""

GOAL_KEY = "samp_goal"
"""The take's goal, in Blender's world."""

GROUND_KEY = "samp_ground"
"""Height in metres of the floor that was assumed in a scene without one."""

HANDS_KEY = "samp_hands"
"""Hands that are on something, with the frame in which their numbers begin; network frame."""

MEASURES_KEY, BEFORE_KEY = "samp_measures", "samp_before"
"""Measures of the take, and for a refined take those of its source."""

WARNINGS_KEY = "samp_warnings"
"""What is wrong with the take: sentences, one a line."""

STAR_KEY = "samp_star"

CHARACTER_KEY = "samp_character"
"""Name of the armature that the take was made for."""

MEASURES = (
    "position_error_cm", "rotation_error_deg", "penetration_max_cm", "foot_slide_cm_s", "stance_slide_cm_s",
    "contact", "jerk_m_s3",
)  # fmt: skip
"""Names of the measures that are kept."""


def is_take(action: bpy.types.Action | None) -> bool:
    """Return whether an Action is a take of this add-on."""
    return action is not None and MOTION_KEY in action


def write_motion(action: bpy.types.Action, motion: Motion, frame_start: int) -> None:
    """Store what keyframes cannot show of a motion that begins in frame_start."""
    notes = {"frame_start": frame_start, "frame_end": frame_start + len(motion) - 1}
    if motion.interaction_start is not None:
        notes["interaction_start"] = frame_start + motion.interaction_start
    for key in ("contacts", "actions"):
        values = getattr(motion, key)
        if values is not None:
            notes[key] = values.astype(float).ravel().tolist()
    action[MOTION_KEY] = notes


def read_motion(action: bpy.types.Action, start: int, end: int) -> dict:
    """Return contacts, actions and interaction start of frames start to end, as fields of a Motion.

    Empty where the Action has no notes or they do not cover all of these frames.
    """
    notes = action.get(MOTION_KEY)
    if notes is None or start < notes["frame_start"] or end > notes["frame_end"]:
        return {}
    chosen = slice(start - notes["frame_start"], end + 1 - notes["frame_start"])
    total = notes["frame_end"] - notes["frame_start"] + 1
    result = {
        key: np.array(notes[key][:], dtype=np.float64).reshape(total, -1)[chosen]
        for key in ("contacts", "actions")
        if key in notes
    }
    if start <= notes.get("interaction_start", start - 1) <= end:
        result["interaction_start"] = notes["interaction_start"] - start
    return result


def take_end(action: bpy.types.Action) -> int:
    """Return the take's last frame, however long other keys go on; the Action's where it is no take."""
    notes = action.get(MOTION_KEY)
    return int(np.floor(action.frame_range[1])) if notes is None else int(notes["frame_end"])


def write_goal(action: bpy.types.Action, goal: Goal) -> None:
    """Store a goal, given in the network frame."""
    action[GOAL_KEY] = {
        "position": frames.to_blender(goal.position).tolist(),
        "direction": frames.to_blender(goal.direction).tolist(),
        "action": goal.action,
    }


def read_goal(action: bpy.types.Action) -> Goal | None:
    """Return the stored goal in the network frame, or None."""
    stored = action.get(GOAL_KEY)
    if stored is None:
        return None
    position, direction = (frames.to_network(np.array(stored[key][:])) for key in ("position", "direction"))
    return Goal(position, direction, stored["action"])


def write_ground(action: bpy.types.Action, height: float | None) -> None:
    """Store the height (metres) of the floor that was assumed; None where the scene has its own floor."""
    if height is not None:
        action[GROUND_KEY] = float(height)


def read_ground(action: bpy.types.Action) -> float | None:
    """Return the height (metres) of the assumed floor, or None."""
    return action.get(GROUND_KEY)


def write_hands(action: bpy.types.Action, hands: Sequence[HandContact], frame_start: int) -> None:
    """Store hands that are on something, from frame_start on."""
    action[HANDS_KEY] = {str(k): hand.stored() | {"frame": frame_start} for k, hand in enumerate(hands)}


def read_hands(action: bpy.types.Action, start: int, end: int) -> tuple[HandContact, ...]:
    """Return the hands that are on something in frames start to end."""
    stored = action.get(HANDS_KEY)
    if stored is None:
        return ()
    from ...refine.hands import palm  # numpy only, but the panel reads the other notes at every redraw

    found = [
        palm.HandContact.of(one).between(start - one["frame"], end - one["frame"]) for one in stored.values()
    ]
    return tuple(hand for hand in found if hand.weight.any())


def write_measures(action: bpy.types.Action, after: Mapping, before: Mapping | None = None) -> None:
    """Store measures (of evaluation.metrics.measure). before: measures of the take that this one was refined from."""
    for key, numbers in ((MEASURES_KEY, after), (BEFORE_KEY, before)):
        known = {name: float(numbers[name]) for name in MEASURES if (numbers or {}).get(name) is not None}
        if known:
            action[key] = known


def read_measures(action: bpy.types.Action, key: str = MEASURES_KEY) -> dict[str, float]:
    """Return the stored measures; empty where there are none. key: MEASURES_KEY or BEFORE_KEY."""
    stored = action.get(key)
    return {} if stored is None else dict(stored.items())


def write_warnings(action: bpy.types.Action, sentences: Sequence[str]) -> None:
    """Store what is wrong with a take, a sentence for each fault; none removes the note."""
    if sentences:
        action[WARNINGS_KEY] = "\n".join(sentences)
    elif WARNINGS_KEY in action:
        del action[WARNINGS_KEY]


def read_warnings(action: bpy.types.Action) -> list[str]:
    """Return the stored sentences; empty for a take without fault."""
    return [line for line in str(action.get(WARNINGS_KEY, "")).split("\n") if line]


def is_starred(action: bpy.types.Action) -> bool:
    """Return whether an Action has a star."""
    return bool(action.get(STAR_KEY, False))


def set_star(action: bpy.types.Action, state: bool | None = None) -> bool:
    """Set or clear an Action's star, or toggle it where state is None; return the new state."""
    state = not is_starred(action) if state is None else state
    action[STAR_KEY] = state
    return state
