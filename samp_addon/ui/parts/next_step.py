"""The line at the top of the tab that says what to do next.

Drawn at every redraw: look at the settings and the selection only, and at the takes by name.
"""

from __future__ import annotations

import bpy

from ...blender import running_work
from ...blender.actions import notes
from ...blender.scene import candidates
from ...blender.takes import judgement
from ...methods import registry
from ...vocabulary import SEATED
from .. import job_from_settings

NOUNS = {"sit": "a chair, sofa or bench", "lie": "a bed or sofa"}


def sentence(context: bpy.types.Context) -> str:
    """Return what to do next, whatever the state."""
    settings = context.scene.samp
    work = running_work.current()
    if work is not None:
        return "Esc stops it; the scene stays as it is"
    if context.mode not in ("OBJECT", "POSE"):
        return "Go to Object Mode to generate takes"
    needs_place = _needs_place(context, settings)
    if needs_place:
        return needs_place
    take = _shown_take(settings.character)
    label = job_from_settings.button_label(context)
    if take is None:
        return f"Press {label}"
    if judgement.judge(take)[0] in ("BAD", "DOUBTFUL"):
        return "See the line under Takes, or press again for another take"
    return "Press again for another take, or Refine this one"


def _needs_place(context: bpy.types.Context, settings: bpy.types.PropertyGroup) -> str:
    """Return how to choose where the take goes, or nothing where that is chosen."""
    method = registry.find(settings.method)
    if "target" not in method.needs or job_from_settings.sub_goals(context) or settings.target is not None:
        return ""
    if settings.action not in SEATED or candidates.selected(context):
        return ""
    noun = NOUNS[settings.action]
    active = context.view_layer.objects.active
    if active is not None and active.select_get() and active.type not in ("ARMATURE", "EMPTY"):
        return f"{candidates.why_none(context)}: select {noun}"
    return f"Select {noun}"


def _shown_take(character: bpy.types.Object | None) -> bpy.types.Action | None:
    """Return the take that the character plays, or None."""
    data = None if character is None else character.animation_data
    return data.action if data is not None and notes.is_take(data.action) else None
