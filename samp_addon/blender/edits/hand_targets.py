"""A hand of a character on an empty, an object or a vertex, as a new Action."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ... import frames, skeleton
from ...body import proportions
from ...edits.hand_target import EASE, MISSED, HandOnTarget, hand_target, resting_frames
from ...errors import SampError
from ...motion import Motion
from ...pipeline import hand_request
from ...refine.hands.palm import SIDES, HandContact, palm
from ..actions import keyframes, notes, rekeying
from ..actions.action_names import derived_name
from ..character.armature import calibrate
from ..takes import seen
from . import held_things

UPWARD, REACH = 0.8, 0.8
"""Upward component of the normal of a top, and metres within which a hand rests on one."""
KNEES = [skeleton.INDEX[f"{side}_knee"] for side in SIDES]
"""A top below the knees is the seat, the floor or under the thighs."""


@dataclass(frozen=True)
class Baked:
    """The new Action, and how well the hand reaches its target. missed: metres by which it is farthest off. frame: of
    the scene, in which that is. touching: number of fingers that touch the target; None without a grasp."""

    action: bpy.types.Action
    side: str
    target: str
    missed: float
    frame: int
    touching: int | None = None

    def sentence(self) -> str:
        """Return what came of it."""
        if self.missed <= MISSED:
            number = "" if self.touching is None else f", with {self.touching} of 5 fingers around it"
            return f"The {self.side} hand is on '{self.target}' in '{self.action.name}'{number}."
        return (
            f"The {self.side} hand misses '{self.target}' by {100 * self.missed:.0f} cm in frame {self.frame} of "
            f"'{self.action.name}'; move the target or the character nearer."
        )


@dataclass(frozen=True)
class _Point:
    """A point fixed to an object, in its own axes. place: (3,); normal: (3,) of the surface there, or None."""

    place: np.ndarray
    normal: np.ndarray | None


def bake(
    context: bpy.types.Context,
    target: bpy.types.Object,
    side: str,
    character: str = "",
    first: int | None = None,
    last: int | None = None,
    ease: float = EASE,
    vertex: int | None = None,
    action_name: str = "",
    fingers: bool = False,
) -> Baked:
    """Bring a hand of a character to an object in some frames of its active Action, as a new Action, now active.

    target: an empty; or a mesh, touched at ``vertex``, or without one where its surface is nearest to the hand. first,
    last: frames of the scene; those of the rest where left out. ease: seconds of the way there, and back.
    fingers: whether they bend around the target. Raise SampError where there is no character, Action or vertex, for an
    empty range, for the character's own objects, and where fingers are to hold a target without a surface.
    """
    if side not in SIDES:
        raise SampError(f"There is no hand '{side}'; choose {' or '.join(SIDES)}.")
    owner, action = keyframes.find_action(context, character, action_name)
    _require_other(owner, target)
    keyframes.require_editable(owner)
    begin, end = rekeying.frame_span(action)
    motion = keyframes.read_motion(owner, action, begin, end, context.scene)
    made, frame = _solved(context, target, motion, side, begin, first, last, ease, vertex)
    made, touching = held_things.grasped(context, target, made, begin) if fingers else (made, None)
    new = _written(owner, action, motion, made, begin, derived_name(action, f" {side} hand"))
    return Baked(new, side, target.name, made.missed, frame, touching)


def applied(
    context: bpy.types.Context, owner: bpy.types.Object, motion: Motion, texts: Sequence[str], begin: int
) -> tuple[Motion, list[HandContact], list[str]]:
    """Return a motion, not written yet, with the hands of a job on their targets; the contacts; and a sentence for each
    that does not reach its target or has none. begin: the frame of the scene in which the motion begins."""
    contacts, remarks = [], []
    if texts:
        rest = calibrate(owner).rest_joints
        motion = proportions.adapt(motion, rest).resampled(keyframes.frames_per_second(context.scene))
    for text in texts:
        wanted = hand_request.parse(text)
        target = context.scene.objects.get(wanted.target)
        try:
            if target is None:
                raise SampError(f"There is no '{wanted.target}' for the {wanted.side} hand.")
            _require_other(owner, target)
            made, frame = _solved(
                context, target, motion, wanted.side, begin, wanted.first, wanted.last, EASE, wanted.vertex
            )
        except SampError as error:
            remarks.append(str(error))
            continue
        motion = made.motion
        contacts.append(made.contact)
        if made.missed > MISSED:
            remarks.append(
                f"The {wanted.side} hand misses '{target.name}' by {100 * made.missed:.0f} cm in frame {frame}."
            )
    return motion, contacts, remarks


def _solved(
    context: bpy.types.Context,
    target: bpy.types.Object,
    motion: Motion,
    side: str,
    begin: int,
    first: int | None,
    last: int | None,
    ease: float,
    vertex: int | None,
) -> tuple[HandOnTarget, int]:
    """Return the motion with a hand on a target, and the frame of the scene in which it is farthest off."""
    rest, end = resting_frames(motion), begin + len(motion) - 1
    low = rest[0] if first is None else max(first - begin, 0)
    high = rest[1] if last is None else min(last, end) - begin
    if high < low:
        raise SampError(f"The take has no frames in this range; choose frames from {begin} to {end}.")
    point = _point(context, target, vertex, motion, side, low, begin)
    places, normals = _over_time(context, target, point, range(begin, end + 1))
    made = hand_target(motion, side, places, low, high, ease, None if normals is None else -normals)
    return made, begin + made.frame


def _written(
    owner: bpy.types.Object,
    action: bpy.types.Action,
    motion: Motion,
    made: HandOnTarget,
    begin: int,
    name: str,
) -> bpy.types.Action:
    """Write the motion as a copy of the Action that knows of the hand, and make it the active one."""
    new, slot = rekeying.rekey_copy(owner, action, motion, made.motion, begin, name)
    busy = made.contact.weight > 0
    before = notes.read_hands(action, begin, begin + len(motion) - 1)
    held = [hand.without(busy) if hand.side == made.contact.side else hand for hand in before]
    notes.write_hands(new, [*(hand for hand in held if hand.weight.any()), made.contact], begin)
    if action.library is None:
        action.use_fake_user = True
    keyframes.activate_action(owner, new, slot)
    return new


def _require_other(owner: bpy.types.Object, target: bpy.types.Object) -> None:
    """Raise SampError where the target is the character or moves with it."""
    above = target
    while above is not None:
        if above == owner or above.find_armature() == owner:
            raise SampError(
                f"'{target.name}' moves with '{owner.name}'; choose a target that it does not carry."
            )
        above = above.parent


def _point(
    context: bpy.types.Context,
    target: bpy.types.Object,
    vertex: int | None,
    motion: Motion,
    side: str,
    frame: int,
    begin: int,
) -> _Point:
    """Return what is touched. Raise SampError for a vertex that is not there."""
    if target.type != "MESH":
        if vertex is not None:
            raise SampError(f"'{target.name}' has no vertices; name a mesh, or leave the vertex out.")
        return _Point(np.zeros(3), None)
    with seen.frame_kept(context.scene):
        context.scene.frame_set(begin + frame)
        shown = target.evaluated_get(context.evaluated_depsgraph_get())
        mesh = shown.data
        if vertex is not None:
            if not 0 <= vertex < len(mesh.vertices):
                raise SampError(
                    f"'{target.name}' has no vertex {vertex}; choose one from 0 to {len(mesh.vertices) - 1}."
                )
            found = mesh.vertices[vertex]
            return _Point(np.array(found.co), np.array(found.normal))
        joints, globals_ = motion.forward_kinematics()
        middle, _ = palm(joints, globals_, motion.rest_joints, side)
        knees = float(joints[frame, KNEES, 1].max())
        return _touched(shown, Vector(frames.to_blender(middle[frame])), knees)


def _touched(shown: bpy.types.Object, hand: Vector, above: float) -> _Point:
    """Return where a hand touches an evaluated mesh: on top of it over a height, such as on an armrest or a table, and
    otherwise where its surface is nearest."""
    mesh = shown.data
    world = np.array(shown.matrix_world, dtype=np.float64)
    inverse = shown.matrix_world.inverted_safe()
    count = len(mesh.polygons)
    flat = {name: np.empty(3 * count, np.float32) for name in ("normal", "center")}
    for name, values in flat.items():
        mesh.polygons.foreach_get(name, values)
    up = flat["normal"].reshape(-1, 3) @ np.linalg.inv(world[:3, :3])
    up = up[:, 2] / np.maximum(np.linalg.norm(up, axis=-1), 1e-9)
    height = (flat["center"].reshape(-1, 3) @ world[:3, :3].T + world[:3, 3])[:, 2]
    chosen = np.flatnonzero((up > UPWARD) & (height > above))
    if len(chosen):
        corners = [shown.matrix_world @ vertex.co for vertex in mesh.vertices]
        tree = BVHTree.FromPolygons(corners, [mesh.polygons[int(k)].vertices[:] for k in chosen])
        place, _, index, _ = tree.find_nearest(hand, REACH)
        if place is not None:
            return _Point(np.array(inverse @ place), np.array(mesh.polygons[int(chosen[index])].normal))
    if not count:
        return _Point(np.zeros(3), None)
    near, place, normal, _ = shown.closest_point_on_mesh(inverse @ hand)
    return _Point(np.array(place), np.array(normal)) if near else _Point(np.zeros(3), None)


def _over_time(
    context: bpy.types.Context, target: bpy.types.Object, point: _Point, times: range
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return place and normal (T, 3) of the point, network frame; the scene's frames are evaluated only where the
    target may move."""
    worlds = np.empty((len(times), 4, 4))
    if seen.mover(target, True) is None:
        worlds[:] = _world(context, target)
    else:
        with seen.frame_kept(context.scene):
            for k, frame in enumerate(times):
                context.scene.frame_set(frame)
                worlds[k] = _world(context, target)
    places = worlds[:, :3, :3] @ point.place + worlds[:, :3, 3]
    if point.normal is None:
        return frames.to_network(places), None
    normals = np.linalg.inv(worlds[:, :3, :3]).swapaxes(-1, -2) @ point.normal
    normals = normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-9)
    return frames.to_network(places), frames.to_network(normals)


def _world(context: bpy.types.Context, obj: bpy.types.Object) -> np.ndarray:
    shown = obj.evaluated_get(context.evaluated_depsgraph_get())
    return np.array(shown.matrix_world, dtype=np.float64)
