"""From what is set in the sidebar to a job, and why there is none. Light enough to be asked at every redraw."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..errors import SampError
from ..methods import registry
from ..motion import SEATED
from . import method_options

if TYPE_CHECKING:
    from ..pipeline.job import Job

NO_FURNITURE = frozenset({"ARMATURE", "CAMERA", "LIGHT", "SPEAKER"})
WORDS = {"sit": "Sit Here", "lie": "Lie Here", "walk": "Walk Here", "run": "Run Here"}


def word(settings: bpy.types.PropertyGroup) -> str:
    """What the button says."""
    return WORDS[settings.action]


def why_not(context: bpy.types.Context) -> str:
    """What the button lacks to do anything; empty where it has all."""
    settings = context.scene.samp
    if not registry.find(settings.method).actions:
        return ""
    if settings.action in SEATED and settings.target is None and not _something_clicked(context):
        return f"Click what to {settings.action} on, or choose a target"
    return ""


def job(context: bpy.types.Context) -> Job:
    """The job that is set. Raises SampError where what it needs is missing."""
    from ..blender.scene import targets
    from ..pipeline.job import Job

    settings = context.scene.samp
    method = registry.find(settings.method)
    own = {"method": settings.method, "settings": method_options.values(settings, method)}
    if not method.actions:
        return Job(action="", **own, **common(settings))
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


def chain(context: bpy.types.Context) -> Job:
    """The job of all steps in a row. Raises SampError where there is none, or one of them lacks its target."""
    from ..methods.step import Step
    from ..pipeline.job import Job

    settings, rows = context.scene.samp, []
    if not settings.steps:
        raise SampError("The chain has no steps; add one first.")
    for number, step in enumerate(settings.steps, start=1):
        if step.target is None and step.action in SEATED:
            raise SampError(f"Step {number} has no target; choose what to {step.action} on.")
        target = step.target.name if step.target else ""
        rows.append({"action": step.action, "target": target, "to": None if target else tuple(step.place)})
    return Job(**rows[0], **common(settings), then=tuple(Step(**row) for row in rows[1:]))


def common(settings: bpy.types.PropertyGroup) -> dict:
    """The options that every job has."""
    return {
        "character": character_name(settings),
        "seed": settings.seed,
        "variants": settings.variants,
        "hold": settings.hold,
        "style": round(settings.style, 4),
        "speed": round(settings.speed, 4),
        "refine": settings.refine,
    }


def character_name(settings: bpy.types.PropertyGroup) -> str:
    """The name of the character that is chosen in the sidebar; empty where none is."""
    return settings.character.name if settings.character else ""


def is_furniture(thing: bpy.types.Object) -> bool:
    """Whether a click on an object can mean furniture: no character, no camera."""
    return thing.type not in NO_FURNITURE and thing.find_armature() is None


def _something_clicked(context: bpy.types.Context) -> bool:
    active = context.view_layer.objects.active
    return (active is not None and is_furniture(active)) or any(map(is_furniture, context.selected_objects))
