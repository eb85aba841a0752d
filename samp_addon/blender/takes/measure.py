"""The measures of a finished take, as it is in the scene now."""

from __future__ import annotations

import json

import bpy
import numpy as np

from ... import frames
from ...errors import SampError
from ...evaluation import metrics
from ...evaluation.obstacles import Obstacles
from ...motion import Goal
from ..actions import keyframes
from ..character import armature, character
from ..scene import read_scene

GOAL_KEY = "samp_goal"
"""Custom property of an Action: where its take was to end, in Blender's world."""

GROUND_KEY = "samp_ground"
"""Custom property of an Action: height of the floor that was assumed for it, in a scene that has none."""

TEXT = "SAMP measures"


def remember_goal(action: bpy.types.Action, goal: Goal) -> None:
    """Notes a take's goal with its Action."""
    action[GOAL_KEY] = {
        "position": frames.to_blender(goal.position).tolist(),
        "direction": frames.to_blender(goal.direction).tolist(),
        "action": goal.action,
    }


def remembered_goal(action: bpy.types.Action) -> Goal | None:
    """The goal noted with an Action, network frame."""
    noted = action.get(GOAL_KEY)
    if noted is None:
        return None
    position, direction = (frames.to_network(np.array(noted[key][:])) for key in ("position", "direction"))
    return Goal(position, direction, noted["action"])


def remember_ground(action: bpy.types.Action, height: float | None) -> None:
    """Notes with a take's Action the floor that was assumed under it, metres; None where the scene has its own."""
    if height is not None:
        action[GROUND_KEY] = float(height)


def remembered_ground(action: bpy.types.Action) -> float | None:
    """The height of the floor noted with an Action, metres."""
    return action.get(GROUND_KEY)


def find_take(
    context: bpy.types.Context, name: str = "", action_name: str = ""
) -> tuple[bpy.types.Object, bpy.types.Action]:
    """A character (see armature.find) and its Action, the active one if unnamed.

    Raises SampError where there is no such character or Action.
    """
    owner = armature.find(context, name)
    data = owner.animation_data
    action = bpy.data.actions.get(action_name) if action_name else data and data.action
    if action is None:
        wanted = f"There is no Action '{action_name}'" if action_name else f"'{owner.name}' has no Action"
        raise SampError(f"{wanted}; generate or choose a take first.")
    return owner, action


def measure_take(context: bpy.types.Context, name: str = "", action_name: str = "") -> tuple[str, dict]:
    """Name and measures of a character's Action, the active one if unnamed, against the scene as it is.

    Raises SampError where there is no such character or Action.
    """
    owner, action = find_take(context, name, action_name)
    shown = keyframes.read_motion(owner, action, scene=context.scene)
    people = [thing for thing in context.scene.objects if armature.is_smplx(thing)]
    triangles = read_scene.read_scene(context, people).triangles
    goal = remembered_goal(action)
    return action.name, metrics.measure(
        shown, goal, Obstacles(triangles), _floor(shown), character.body_of(owner)
    )


def write_text(name: str, numbers: dict) -> bpy.types.Text:
    """Puts measures into the text block that the artist can open; what it held before is replaced."""
    text = bpy.data.texts.get(TEXT) or bpy.data.texts.new(TEXT)
    text.from_string(json.dumps({"action": name, "metrics": numbers}, indent=1) + "\n")
    return text


def sentence(name: str, numbers: dict, text: str) -> str:
    """The most telling measures in one line."""
    parts = []
    if "position_error_cm" in numbers:
        away, turned = numbers["position_error_cm"], numbers["rotation_error_deg"]
        parts.append(f"{away:.1f} cm and {turned:.0f} deg from the goal")
    parts.append(f"foot slide {numbers['foot_slide_cm_s']:.1f} cm/s")
    parts.append(f"deepest penetration {numbers['penetration_max_cm']:.1f} cm")
    return f"'{name}': {', '.join(parts)}; all in the text '{text}'."


def _floor(motion: object) -> float:
    """The height on which the feet stand most: the middle of the soles' lowest places."""
    from ...evaluation import feet

    return float(np.median(feet.sole_tracks(motion)[1].min(1)) / 100)
