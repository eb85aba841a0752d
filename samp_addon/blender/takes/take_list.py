"""The takes that a file holds: Actions made here, with their measures; shown, starred, pushed down and deleted.

The panel asks for these while it is drawn: nothing heavy is imported here.
"""

from __future__ import annotations

from collections.abc import Mapping

import bpy

from ...errors import SampError
from .. import compat

NOTES = "samp"
"""Custom property of an Action that makes it a take: what it knows beyond its keyframes (actions.py)."""
MEASURES_KEY, BEFORE_KEY = "samp_measures", "samp_before"
"""Custom properties of an Action: its measures, and for a refined one those of what it was refined from."""
STAR_KEY = "samp_star"
KEPT = (
    "position_error_cm", "rotation_error_deg", "penetration_max_cm", "foot_slide_cm_s", "stance_slide_cm_s",
    "contact", "jerk_m_s3",
)  # fmt: skip


def is_take(action: bpy.types.Action | None) -> bool:
    """Whether an Action was made here."""
    return action is not None and NOTES in action


def takes() -> list[bpy.types.Action]:
    """All takes of the file, by name."""
    return [action for action in bpy.data.actions if is_take(action)]


def remember_measures(action: bpy.types.Action, after: Mapping, before: Mapping | None = None) -> None:
    """Notes a take's measures (evaluation.metrics.measure) with its Action; before: of what it was refined from."""
    for key, numbers in ((MEASURES_KEY, after), (BEFORE_KEY, before)):
        known = {name: float(numbers[name]) for name in KEPT if (numbers or {}).get(name) is not None}
        if known:
            action[key] = known


def measures(action: bpy.types.Action, key: str = MEASURES_KEY) -> dict[str, float]:
    """The measures noted with an Action; none where there are none."""
    noted = action.get(key)
    return {} if noted is None else dict(noted.items())


def find(name: str) -> bpy.types.Action:
    """The take of this name. Raises SampError where there is none."""
    action = bpy.data.actions.get(name)
    if not is_take(action):
        raise SampError(f"There is no take '{name}'; choose one from the list.")
    return action


def show(
    context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action, fit: bool = False
) -> None:
    """Makes a take the character's active Action. fit: the scene's frame range becomes the take's."""
    from ..actions import keyframes

    keyframes.refuse_locked(owner)
    keyframes.activate_action(owner, action)
    first, last = (round(frame) for frame in action.frame_range)
    if fit:
        context.scene.frame_start, context.scene.frame_end = max(first, 0), last
    if not first <= context.scene.frame_current <= last:
        context.scene.frame_set(first)


def star(action: bpy.types.Action, state: bool | None = None) -> bool:
    """Stars a take, or takes its star away; left out, the other way round. Returns what it is now."""
    state = not action.get(STAR_KEY, False) if state is None else state
    action[STAR_KEY] = state
    return state


def delete(action: bpy.types.Action) -> None:
    """Takes a take out of the file. Raises SampError where an NLA strip plays it or it is linked."""
    if action.library is not None:
        raise SampError(f"'{action.name}' is linked from another file; delete it there.")
    for thing in bpy.data.objects:
        tracks = thing.animation_data.nla_tracks if thing.animation_data else ()
        if any(strip.action == action for track in tracks for strip in track.strips):
            raise SampError(f"An NLA strip of '{thing.name}' plays '{action.name}'; delete the strip first.")
    bpy.data.actions.remove(action)


def delete_unstarred() -> tuple[int, int]:
    """Deletes all takes without a star; returns how many, and how many of them had to be kept."""
    deleted = kept = 0
    for action in takes():
        if action.get(STAR_KEY, False):
            continue
        try:
            delete(action)
            deleted += 1
        except SampError:
            kept += 1
    return deleted, kept


def show_some(owner: bpy.types.Object) -> None:
    """Where a character's active take was deleted: shows it another one, a starred one rather than others."""
    data = owner.animation_data
    if data is None or data.action is not None or data.use_tweak_mode or not owner.is_editable:
        return
    left = sorted(takes(), key=lambda action: bool(action.get(STAR_KEY, False)))
    if left:
        compat.assign(owner, left[-1])


def push_down(owner: bpy.types.Object, action: bpy.types.Action) -> bpy.types.NlaTrack:
    """Puts a take on an NLA track of its own, where it plays; the character has no active Action then."""
    from ..actions import keyframes

    keyframes.refuse_locked(owner)
    data = owner.animation_data or owner.animation_data_create()
    if data.action is not None:
        data.action.use_fake_user = True
    compat.assign(owner, None)
    track = data.nla_tracks.new()
    track.name = action.name
    strip = track.strips.new(action.name, round(action.frame_range[0]), action)
    compat.fit_strip(strip, owner)
    return track
