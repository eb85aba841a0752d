"""Turns the sidebar's settings into a job, or says what is missing. Cheap enough for every redraw."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np

from .. import frames
from ..blender.character import measures
from ..blender.scene import candidates
from ..blender.sub_goals import arrows
from ..errors import SampError
from ..methods import registry
from ..vocabulary import SEATED
from . import method_options, sub_goal_settings
from .cast import jobs

if TYPE_CHECKING:
    from ..methods.method import Method
    from ..pipeline.cast.cast import Cast
    from ..pipeline.job import Job
    from ..pipeline.placing import PosturesAt, Spot

BUTTON_LABELS = {"sit": "Sit Here", "lie": "Lie Here", "walk": "Walk Here", "run": "Run Here"}


def button_label(context: bpy.types.Context) -> str:
    """Return the label of the generate button."""
    settings = context.scene.samp
    method = registry.find(settings.method)
    if sub_goals(context):
        return "Bake"
    return BUTTON_LABELS[settings.action] if method.actions else method.label


def why_not(context: bpy.types.Context) -> str:
    """Return why no job can be made from the settings; empty if one can."""
    settings = context.scene.samp
    if not registry.find(settings.method).actions:
        return ""
    if found := sub_goals(context):
        enough = len(found) > 1 or settings.start_from == "POSE"
        return "" if enough else "There is only one sub-goal; add another one, the first one is the start"
    if settings.action in SEATED and settings.target is None and not candidates.selected(context):
        reason = candidates.why_none(context)
        known = "" if reason.startswith("No furniture") else f"{reason}; "
        text = f"{known}select the furniture to {settings.action} on, or choose a target"
        return text[:1].upper() + text[1:]
    return ""


def job(context: bpy.types.Context, name: str = "") -> Job:
    """Return the job of the current settings. Raise SampError where a target is missing.

    name: of another method than the chosen one.
    """
    from ..blender.scene import targets
    from ..pipeline.job import Job

    settings = context.scene.samp
    method = registry.find(name or settings.method)
    own = {"method": method.name, "settings": method_options.values(settings, method)}
    if not method.actions:
        return Job(action="", **own, **common(settings))
    if sub_goals(context, name):
        character = {"character": sub_goal_settings.owner(context).name, "shape": {}}
        return Job(action="", **own, **common(settings) | character)
    target = settings.target.name if settings.target else ""
    if not target and settings.action in SEATED:
        target = targets.clicked_target(context)
    return Job(
        action=settings.action,
        target=target,
        to=None if target else tuple(context.scene.cursor.location),
        **own,
        **common(settings),
    )


def cast(context: bpy.types.Context) -> Cast | None:
    """Return the cast of the selected characters, each on a place of its own; None unless there are several."""
    settings = context.scene.samp
    method = registry.find(settings.method)
    if not method.actions or sub_goals(context):
        return None
    own = {"method": method.name, "settings": method_options.values(settings, method)}
    target = settings.target.name if settings.target else ""
    to = None if target else tuple(context.scene.cursor.location)
    return jobs.of_selection(context, settings.action, own | common(settings), target, to)


def sub_goals(context: bpy.types.Context, name: str = "") -> list[bpy.types.Object]:
    """Return the sub-goals that the next take passes; none where the method has none, or the character.

    name: of another method than the chosen one.
    """
    if "sub_goals" not in registry.find(name or context.scene.samp.method).needs:
        return []
    return arrows.listed(context, sub_goal_settings.owner(context))


def job_of_steps(context: bpy.types.Context) -> Job:
    """Return the job of all steps as one take. Raise SampError where there are no steps, or one needs a target."""
    from ..methods.step import Step
    from ..pipeline.job import Job

    settings, rows = context.scene.samp, []
    if not settings.steps:
        raise SampError("There are no steps; add one first.")
    shared = common(settings)
    for number, step in enumerate(settings.steps, start=1):
        method = registry.find(step.method or registry.DEFAULT)
        own = {"method": method.name, "settings": method_options.values(settings, method)}
        own = _with_posture(
            own, step.posture if "posture" in {option.name for option in method.options} else ""
        )
        if not step_has_action(context, step):
            rows.append({"action": "", **own})
            if sub_goals(context, method.name):
                shared |= {"character": sub_goal_settings.owner(context).name, "shape": {}}
            continue
        if step.target is None and step.action in SEATED:
            raise SampError(f"Step {number} has no target; choose what to {step.action} on.")
        target = step.target.name if step.target else ""
        place = (*step.place, *((math.degrees(step.yaw),) if step.use_yaw else ()))
        exact = step.use_yaw and step.action in SEATED
        to, point = None if target else place, place if exact and target else None
        rows.append({"action": step.action, "target": target, "to": to, "point": point, **own})
    return Job(**rows[0], **shared, then=tuple(Step(**row) for row in rows[1:]))


def job_at(context: bpy.types.Context, spot: Spot) -> Job:
    """Return the job of one action at a spot, with the other settings of the sidebar."""
    from ..pipeline.job import Job

    settings = context.scene.samp
    method = method_of_places(settings)
    own = {"method": method.name, "settings": method_options.values(settings, method)}
    own = _with_posture(own, spot.posture)
    place = (*map(float, frames.to_blender(spot.point)), math.degrees(spot.yaw))
    if spot.target:
        return Job(action=spot.action, target=spot.target, point=place, **own, **common(settings))
    to = place if np.any(spot.goal.direction) else place[:3]
    return Job(action=spot.action, to=to, **own, **common(settings))


def add_step(context: bpy.types.Context, spot: Spot) -> None:
    """Add the action at a spot to the list of steps. Raise SampError for furniture that is no object of its own."""
    settings = context.scene.samp
    target = context.scene.objects.get(spot.target) if spot.target else None
    if spot.target and target is None:
        raise SampError(f"'{spot.target}' is part of a collection instance, which steps cannot name.")
    step = settings.steps.add()
    step.method, step.action, step.target = method_of_places(settings).name, spot.action, target
    step.place = frames.to_blender(spot.point)
    step.use_yaw, step.yaw = bool(np.any(spot.goal.direction)), spot.yaw
    step.posture = spot.posture
    settings.step_index = len(settings.steps) - 1


def postures_at(context: bpy.types.Context) -> PosturesAt | None:
    """Return the function that says which postures there are at a goal; None where the method has none."""
    return getattr(method_of_places(context.scene.samp), "postures_at", None)


def _with_posture(own: dict, posture: str) -> dict:
    """Return a method's name and settings, with a posture in place of the sidebar's if there is one."""
    return {**own, "settings": {**own["settings"], "posture": posture}} if posture else own


def method_of_places(settings: bpy.types.PropertyGroup) -> Method:
    """Return the chosen method where it takes places on furniture, else the one that does."""
    method = registry.find(settings.method)
    return method if "goals" in method.needs else registry.find(registry.DEFAULT)


def owner(context: bpy.types.Context) -> bpy.types.Object | None:
    """Return the character of the settings, else the selected one or the only one; None where one is to be made."""
    from ..blender.character import armature

    settings = context.scene.samp
    if settings.character is not None:
        return settings.character
    if not any(armature.is_smplx(obj) for obj in context.scene.objects):
        return None
    selected = [obj for obj in context.selected_objects if armature.is_smplx(obj)]
    return selected[0] if len(selected) == 1 else armature.find(context)


def step_has_action(context: bpy.types.Context, step: bpy.types.PropertyGroup) -> bool:
    """Return whether a step has an action: not where its method takes none, or passes the character's sub-goals."""
    name = step.method or registry.DEFAULT  # empty where the method is not installed any more
    return bool(registry.find(name).actions) and not sub_goals(context, name)


def common(settings: bpy.types.PropertyGroup) -> dict:
    """Return the options common to all jobs."""
    return {
        "character": character_name(settings),
        "shape": {} if settings.character else measures.values(settings),
        "seed": settings.seed,
        "variants": settings.variants,
        "hold": settings.hold,
        "style": round(settings.style, 4),
        "speed": round(settings.speed, 4),
        "refine": settings.refine,
    }


def character_name(settings: bpy.types.PropertyGroup) -> str:
    """Return the name of the character in the settings, or an empty string."""
    return settings.character.name if settings.character else ""
