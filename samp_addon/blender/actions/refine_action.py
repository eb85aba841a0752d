"""Refines an Action of an SMPL-X armature; the result is a new Action.

Three steps: ``read`` the optimiser's input, refine without Blender (refine/refinement.py, optionally in a thread),
``write``. Nothing in the file changes before ``write``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from ...body.human import Human
from ...errors import SampError
from ...evaluation import guards
from ...motion import Goal, Motion
from ...progress import Progress
from ...refine import refinement as optimiser
from ...refine.hands.palm import HandContact
from ...refine.refinement import Refined, Settings, Surroundings
from ...scene.geometry import SceneGeometry
from .. import compat
from ..character import characters
from ..character.character import body_of, has_surface
from ..scene import read_scene
from ..thread_run import ThreadRun, one_slice
from . import keyframes, notes, rekeying
from .action_names import derived_name

SUFFIX = " refined"
UNSOLVED = 0.02
"""Metres: penetration above this is reported after refinement."""

LARGEST_VALUE = 1e30
"""Larger key values count as infinite: Blender stores infinity as the largest float."""

_BONE = re.compile(r'pose\.bones\["((?:[^"\\]|\\.)*)"\]')
_TRANSFORMS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
_SUMMARY = (
    ("deepest penetration", "penetration_max_cm", "cm", 1),
    ("foot slide", "foot_slide_cm_s", "cm/s", 1),
    ("contact", "contact", "%", 100),
)

Refine = Callable[..., Refined]


@dataclass(frozen=True)
class Plan:
    """Input of a refinement. motion: the Action's frames from frame_start on. remarks: sentences for the artist.
    hands: that are on something."""

    owner: bpy.types.Object
    action: bpy.types.Action
    motion: Motion
    frame_start: int
    surroundings: Surroundings
    goal: Goal | None
    body: Human
    settings: Settings
    remarks: tuple[str, ...] = ()
    hands: tuple[HandContact, ...] = ()


@dataclass(frozen=True)
class Result:
    """The new Action and the optimiser's result. remarks: sentences for the artist."""

    action: bpy.types.Action
    refined: Refined
    remarks: tuple[str, ...] = ()


def run(
    context: bpy.types.Context,
    character: str = "",
    action_name: str = "",
    frame_start: int | None = None,
    frame_end: int | None = None,
    settings: Settings | None = None,
    progress: Progress = lambda stage, share: None,
    refine: Refine | None = None,
) -> Result:
    """Refine an Action; see ``read``. Raise SampError, and any exception of progress."""
    plan = read(context, character, action_name, frame_start, frame_end, settings)
    return write(context, plan, _optimise(plan, progress, refine))


def begin(
    context: bpy.types.Context,
    character: str = "",
    action_name: str = "",
    frame_start: int | None = None,
    frame_end: int | None = None,
    settings: Settings | None = None,
    refine: Refine | None = None,
) -> ThreadRun:
    """Start ``run`` in a background thread; finishing it returns the Result."""
    plan = read(context, character, action_name, frame_start, frame_end, settings)
    return ThreadRun(
        lambda progress: _optimise(plan, progress, refine),
        lambda context, refined: one_slice(lambda: write(context, plan, refined)),
        plan.owner,
    )


def _optimise(plan: Plan, progress: Progress, refine: Refine | None) -> Refined:
    refine = refine or optimiser.refine
    held = {"hands": plan.hands} if plan.hands else {}
    return refine(plan.motion, plan.surroundings, plan.goal, plan.body, plan.settings, progress, **held)


def read(
    context: bpy.types.Context,
    character: str = "",
    action_name: str = "",
    frame_start: int | None = None,
    frame_end: int | None = None,
    settings: Settings | None = None,
) -> Plan:
    """Read a character's Action, by default the active one, and the scene around it.

    frame_start, frame_end: by default the whole Action. Raise SampError where there is no such character or Action,
    where the Action cannot be read or written, and, naming bone and frame, where a value is not a finite number.
    """
    owner, action = keyframes.find_action(context, character, action_name)
    keyframes.require_editable(owner)
    _require_finite(owner, action)
    start, end = _range(action, frame_start, frame_end)
    _require_still_object(owner, action, np.arange(start, end + 1))
    people = characters.people(context)
    scene = read_scene.read_scene(context, people)
    remarks = ()
    if not has_surface(context, owner):
        remarks = (f"'{owner.name}' has no body surface; the default human was fitted to its bones.",)
    return Plan(
        owner=owner,
        action=action,
        motion=keyframes.read_motion(owner, action, start, end, context.scene),
        frame_start=start,
        surroundings=surroundings(context, scene, notes.read_ground(action)),
        goal=notes.read_goal(action) if end >= notes.take_end(action) else None,
        body=body_of(owner),
        settings=settings or Settings(),
        remarks=remarks,
        hands=notes.read_hands(action, start, end),
    )


def surroundings(
    context: bpy.types.Context, scene: SceneGeometry, floor: float | None = None
) -> Surroundings:
    """Return a scene with the cushion depth of each triangle. floor: height in metres where the scene has no floor."""
    depths = read_scene.cushion_depths(context, scene.names)
    return Surroundings(scene.triangles, depths[scene.object_ids], floor)


def write(context: bpy.types.Context, plan: Plan, refined: Refined) -> Result:
    """Write the refined motion as a new Action and make it the armature's active one; the source stays unchanged.

    The new Action is a copy of the source with new keys only where the motion changed; other frames, other bones and
    notes are copied. On an error nothing is left behind. Raise SampError if the source was deleted meanwhile.
    """
    if plan.action not in set(bpy.data.actions):
        raise SampError("The Action was deleted during refinement; start again.")
    keyframes.require_editable(plan.owner)
    new, slot = rekeying.rekey_copy(
        plan.owner,
        plan.action,
        plan.motion,
        refined.motion,
        plan.frame_start,
        derived_name(plan.action, SUFFIX),
    )
    if plan.action.library is None:
        plan.action.use_fake_user = True  # also where another Action was active
    keyframes.activate_action(plan.owner, new, slot)
    notes.write_measures(new, refined.after, refined.before)
    kept = [text for text in notes.read_warnings(new) if not text.startswith(guards.MEASURED)]
    notes.write_warnings(new, [*kept, *guards.warnings(refined.after)])
    return Result(new, refined, plan.remarks)


def sentence(result: Result) -> str:
    """Return a summary of a refinement: measures before and after, and remaining penetration."""
    refined = result.refined
    changes = [
        f"{name} {refined.before[key] * scale:.1f} to {refined.after[key] * scale:.1f} {unit}"
        for name, key, unit, scale in _SUMMARY
        if key in refined.before and key in refined.after
    ]
    parts = [f"'{result.action.name}': {', '.join(changes) or 'refined'}.", *result.remarks, *refined.notes]
    reported = any("deep in the scene" in note for note in refined.notes)  # by the optimiser itself
    if refined.unsolved > UNSOLVED and not reported:
        parts.append(f"The body is still {refined.unsolved * 100:.0f} cm deep in the scene somewhere.")
    return " ".join(parts)


def _range(action: bpy.types.Action, start: int | None, end: int | None) -> tuple[int, int]:
    """Clamp the requested frames to the Action. Raise SampError where none are left."""
    first, last = rekeying.frame_span(action)
    own_first, own_last = action.frame_range
    start = int(np.floor(own_first)) if start is None else max(start, first)
    end = int(np.ceil(own_last)) if end is None else min(end, last)
    if end < start:
        raise SampError(f"'{action.name}' has no frames in this range; choose frames from {first} to {last}.")
    return start, end


def _require_finite(owner: bpy.types.Object, action: bpy.types.Action) -> None:
    """Raise SampError where a curve has a NaN or infinite value, or no curve animates a bone."""
    curves = list(compat.curves(action, owner))
    if not any(_BONE.match(curve.data_path) for curve in curves):
        raise SampError(f"'{action.name}' animates no bone of '{owner.name}'; choose another Action.")
    for curve in curves:
        frame = _invalid_frame(curve)
        if frame is not None:
            bone = _BONE.match(curve.data_path)
            name = bpy.utils.unescape_identifier(bone[1]) if bone else curve.data_path
            raise SampError(
                f"'{action.name}' has a value that is not a finite number at '{name}' in frame {frame}; "
                "correct or delete that key."
            )


def _invalid_frame(curve: bpy.types.FCurve) -> int | None:
    """Return the frame of a curve's first key with a NaN or infinite value or handle, or None."""
    points, parts = curve.keyframe_points, []
    for name in ("co", "handle_left", "handle_right"):
        values = np.empty(len(points) * 2, dtype=np.float32)
        points.foreach_get(name, values)
        parts.append(values.reshape(-1, 2))
    invalid = ~(np.abs(np.concatenate(parts, axis=1)) < LARGEST_VALUE).all(1)  # NaN compares false
    return int(np.nan_to_num(parts[0][invalid][0, 0], posinf=0, neginf=0)) if invalid.any() else None


def _require_still_object(owner: bpy.types.Object, action: bpy.types.Action, times: np.ndarray) -> None:
    """Raise SampError where the Action moves the armature object: refinement changes bones only."""
    for curve in compat.curves(action, owner):
        if curve.data_path in _TRANSFORMS and np.ptp([curve.evaluate(time) for time in times]) > 1e-5:
            raise SampError(
                f"'{action.name}' animates the object '{owner.name}' itself; animate its bone 'pelvis' instead."
            )
