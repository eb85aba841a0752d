"""The takes in a file: show, push down and delete them.

The panel calls this at every redraw: import nothing heavy here.
"""

from __future__ import annotations

import bpy

from ...errors import SampError
from .. import compat
from ..actions import keyframes, notes


def takes() -> list[bpy.types.Action]:
    """Return all takes of the file, by name."""
    return [action for action in bpy.data.actions if notes.is_take(action)]


def listed(settings: bpy.types.PropertyGroup) -> list[bpy.types.Action]:
    """Return the takes of the list, by name: those of the chosen character, or all."""
    chosen = settings.character if settings.only_character else None
    return takes() if chosen is None else [action for action in takes() if _belongs(action, chosen)]


def _belongs(action: bpy.types.Action, owner: bpy.types.Object) -> bool:
    """Whether a take is a character's; also where its own character was renamed or is gone."""
    name = action.get(notes.CHARACTER_KEY, owner.name)
    return name == owner.name or name not in bpy.data.objects


def step(settings: bpy.types.PropertyGroup, owner: bpy.types.Object, count: int) -> bpy.types.Action:
    """Return the take that is so many rows below the character's active one; the list is a ring."""
    rows = listed(settings)
    if not rows:
        raise SampError("There is no take yet; generate one first.")
    active = owner.animation_data.action if owner.animation_data is not None else None
    if active not in rows:
        return rows[0 if count > 0 else -1]
    return rows[(rows.index(active) + count) % len(rows)]


def find(name: str) -> bpy.types.Action:
    """Return the take of this name. Raise SampError where there is none."""
    action = bpy.data.actions.get(name)
    if not notes.is_take(action):
        raise SampError(f"There is no take '{name}'; choose one from the list.")
    return action


def show(
    context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action, fit: bool = False
) -> None:
    """Make a take the character's active Action. fit: set the scene's frame range to the take's."""
    keyframes.require_editable(owner)
    keyframes.activate_action(owner, action)
    first, last = (round(frame) for frame in action.frame_range)
    if fit:
        context.scene.frame_start, context.scene.frame_end = max(first, 0), last
    if not first <= context.scene.frame_current <= last:
        context.scene.frame_set(first)


def delete(action: bpy.types.Action) -> None:
    """Delete a take. Raise SampError where an NLA strip plays it or it is linked from another file."""
    if action.library is not None:
        raise SampError(f"'{action.name}' is linked from another file; delete it there.")
    for obj in bpy.data.objects:
        tracks = obj.animation_data.nla_tracks if obj.animation_data else ()
        if any(strip.action == action for track in tracks for strip in track.strips):
            raise SampError(f"An NLA strip of '{obj.name}' plays '{action.name}'; delete the strip first.")
    bpy.data.actions.remove(action)


def delete_unstarred() -> tuple[int, int]:
    """Delete all takes without a star; return the number deleted and the number that had to be kept."""
    deleted = kept = 0
    for action in takes():
        if notes.is_starred(action):
            continue
        try:
            delete(action)
            deleted += 1
        except SampError:
            kept += 1
    return deleted, kept


def show_remaining(owner: bpy.types.Object) -> None:
    """Show another take on a character whose active take was deleted; starred takes come first."""
    data = owner.animation_data
    if data is None or data.action is not None or data.use_tweak_mode or not owner.is_editable:
        return
    remaining = sorted(takes(), key=notes.is_starred)
    if remaining:
        compat.assign(owner, remaining[-1])


def push_down(owner: bpy.types.Object, action: bpy.types.Action) -> bpy.types.NlaTrack:
    """Put a take on a new NLA track, where it plays; the character then has no active Action."""
    keyframes.require_editable(owner)
    data = owner.animation_data or owner.animation_data_create()
    if data.action is not None:
        data.action.use_fake_user = True
    compat.assign(owner, None)
    track = data.nla_tracks.new()
    track.name = action.name
    strip = track.strips.new(action.name, round(action.frame_range[0]), action)
    compat.fit_strip(strip, owner)
    return track


def to_strip(owner: bpy.types.Object, action: bpy.types.Action, frame: int) -> bpy.types.NlaStrip:
    """Put a take as a strip of its own onto a new NLA track, from a frame of the scene on.

    Nothing else of the NLA changes. If the take is the active Action it is not any more, so that the strip is seen.
    """
    keyframes.require_editable(owner)
    data = owner.animation_data or owner.animation_data_create()
    action.use_fake_user = action.use_fake_user or action.library is None
    if data.action == action:
        compat.assign(owner, None)
    track = data.nla_tracks.new()
    track.name = action.name
    strip = track.strips.new(action.name, frame, action)
    strip.extrapolation = "NOTHING"  # before and after it, the tracks below are seen
    compat.fit_strip(strip, owner)
    return strip
