"""Refine in Blender: an Action of an SMPL-X armature is read, refined, and written as a new Action beside it.

Three steps: ``read`` what the optimiser needs, refine without Blender (refine/refining.py, in a thread if wanted),
``write``. Until ``write`` nothing in the file has changed.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from ...body.human import Human
from ...errors import SampError
from ...motion import Goal, Motion
from ...progress import Progress
from ...refine import refinement as optimiser
from ...refine.refinement import Refined, Settings, Surroundings
from ...scene.geometry import SceneGeometry
from .. import compat
from ..character import armature
from ..character.character import body_of, has_surface
from ..scene import read_scene
from ..thread_run import ThreadRun, one_slice
from . import keyframes, notes, rekeying

SUFFIX = " refined"
LONGEST_NAME = 63
"""Bytes of an Action's name in Blender before 5.0."""

UNSOLVED = 0.02
"""Metres. A body that is still deeper in the scene is spoken of."""

MOST = 1e30
"""Blender stores an infinite value as the largest number that it has."""

_BONE = re.compile(r'pose\.bones\["((?:[^"\\]|\\.)*)"\]')
_PLACES = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
_NUMBERS = (
    ("deepest penetration", "penetration_max_cm", "cm", 1),
    ("foot slide", "foot_slide_cm_s", "cm/s", 1),
    ("contact", "contact", "%", 100),
)

Refine = Callable[..., Refined]


@dataclass(frozen=True)
class Plan:
    """What is refined. motion: of the Action's frames from frame_start on. remarks: sentences for the artist."""

    owner: bpy.types.Object
    action: bpy.types.Action
    motion: Motion
    frame_start: int
    surroundings: Surroundings
    goal: Goal | None
    body: Human
    settings: Settings
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """The new Action, and what the optimiser reports. remarks: sentences for the artist."""

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
    """An Action refined, as a new one; see ``read``. Raises SampError, and whatever progress raises."""
    plan = read(context, character, action_name, frame_start, frame_end, settings)
    return write(context, plan, _refined(plan, progress, refine))


def begin(
    context: bpy.types.Context,
    character: str = "",
    action_name: str = "",
    frame_start: int | None = None,
    frame_end: int | None = None,
    settings: Settings | None = None,
    refine: Refine | None = None,
) -> ThreadRun:
    """The same in a thread beside Blender's window, to be finished into a Result."""
    plan = read(context, character, action_name, frame_start, frame_end, settings)
    return ThreadRun(
        lambda progress: _refined(plan, progress, refine),
        lambda context, refined: one_slice(lambda: write(context, plan, refined)),
        plan.owner,
    )


def _refined(plan: Plan, progress: Progress, refine: Refine | None) -> Refined:
    refine = refine or optimiser.refine
    return refine(plan.motion, plan.surroundings, plan.goal, plan.body, plan.settings, progress)


def read(
    context: bpy.types.Context,
    character: str = "",
    action_name: str = "",
    frame_start: int | None = None,
    frame_end: int | None = None,
    settings: Settings | None = None,
) -> Plan:
    """All that the optimiser needs of a character's Action, the active one if unnamed, and of the scene around it.

    Without frames all of the Action is refined. Raises SampError where there is no such character or Action, where
    the Action cannot be read or written, and, naming bone and frame, where it holds what is no number.
    """
    owner, action = keyframes.find_action(context, character, action_name)
    keyframes.refuse_locked(owner)
    _refuse_broken(owner, action)
    start, end = _range(action, frame_start, frame_end)
    _refuse_moving_object(owner, action, np.arange(start, end + 1))
    people = [obj for obj in context.scene.objects if armature.is_smplx(obj)]
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
    )


def surroundings(
    context: bpy.types.Context, scene: SceneGeometry, floor: float | None = None
) -> Surroundings:
    """A scene that was read, with the give of each triangle's object; floor: of a scene whose triangles hold none."""
    depths = read_scene.cushion_depths(context, scene.names)
    return Surroundings(scene.triangles, depths[scene.object_ids], floor)


def write(context: bpy.types.Context, plan: Plan, refined: Refined) -> Result:
    """The refined motion as a new Action, which becomes the armature's active one; the old one stays as it is.

    The new one is a copy with other keys where something was changed: all else that the old one holds, other frames,
    other bones and its notes, is in it too. If anything goes wrong, nothing is left behind. Raises SampError where
    the Action is gone.
    """
    if plan.action not in set(bpy.data.actions):
        raise SampError("The Action is gone since the work was begun; start again.")
    keyframes.refuse_locked(plan.owner)
    new, slot = rekeying.rekeyed(
        plan.owner, plan.action, plan.motion, refined.motion, plan.frame_start, _new_name(plan.action)
    )
    if plan.action.library is None:
        plan.action.use_fake_user = True  # even where another Action was the active one
    keyframes.activate_action(plan.owner, new, slot)
    notes.write_measures(new, refined.after, refined.before)
    return Result(new, refined, plan.remarks)


def sentence(result: Result) -> str:
    """What the artist is told of a refined take: measures before and after, and what is left to mend."""
    refined = result.refined
    changes = [
        f"{name} {refined.before[key] * scale:.1f} to {refined.after[key] * scale:.1f} {unit}"
        for name, key, unit, scale in _NUMBERS
        if key in refined.before and key in refined.after
    ]
    told = [f"'{result.action.name}': {', '.join(changes) or 'refined'}.", *result.remarks, *refined.notes]
    said = any("deep in the scene" in note for note in refined.notes)  # by the optimiser itself
    if refined.unsolved > UNSOLVED and not said:
        told.append(f"The body is still {refined.unsolved * 100:.0f} cm deep in the scene somewhere.")
    return " ".join(told)


def _range(action: bpy.types.Action, start: int | None, end: int | None) -> tuple[int, int]:
    """The frames that are asked for, as far as the Action has them. Raises SampError where it has none."""
    first, last = rekeying.span(action)
    own_first, own_last = action.frame_range
    start = int(np.floor(own_first)) if start is None else max(start, first)
    end = int(np.ceil(own_last)) if end is None else min(end, last)
    if end < start:
        raise SampError(f"Of these frames '{action.name}' has none; choose some from {first} to {last}.")
    return start, end


def _new_name(action: bpy.types.Action) -> str:
    """The new Action's name, with room for the number that Blender adds where the name is taken."""
    room = LONGEST_NAME - len(SUFFIX) - len(".001")
    return action.name.encode()[:room].decode(errors="ignore") + SUFFIX


def _refuse_broken(owner: bpy.types.Object, action: bpy.types.Action) -> None:
    """Raises SampError where a curve of the armature holds what is no number, or where it has no curves."""
    curves = list(compat.curves(action, owner))
    if not any(_BONE.match(curve.data_path) for curve in curves):
        raise SampError(f"'{action.name}' moves no bone of '{owner.name}'; choose another Action.")
    for curve in curves:
        frame = _broken_frame(curve)
        if frame is not None:
            bone = _BONE.match(curve.data_path)
            name = bpy.utils.unescape_identifier(bone[1]) if bone else curve.data_path
            raise SampError(
                f"'{action.name}' has a value that is no number at '{name}' in frame {frame}; "
                "mend or delete that key."
            )


def _broken_frame(curve: bpy.types.FCurve) -> int | None:
    """The frame of a curve's first key whose value or handles are no numbers."""
    points, parts = curve.keyframe_points, []
    for name in ("co", "handle_left", "handle_right"):
        values = np.empty(len(points) * 2, dtype=np.float32)
        points.foreach_get(name, values)
        parts.append(values.reshape(-1, 2))
    wrong = ~(np.abs(np.concatenate(parts, axis=1)) < MOST).all(1)  # NaN compares false
    return int(np.nan_to_num(parts[0][wrong][0, 0], posinf=0, neginf=0)) if wrong.any() else None


def _refuse_moving_object(owner: bpy.types.Object, action: bpy.types.Action, times: np.ndarray) -> None:
    """Raises SampError where the Action moves the armature as a whole: what is refined is the bones' motion."""
    for curve in compat.curves(action, owner):
        if curve.data_path in _PLACES and np.ptp([curve.evaluate(time) for time in times]) > 1e-5:
            raise SampError(
                f"'{action.name}' moves the object '{owner.name}' itself; move its bone 'pelvis' instead."
            )
