"""Bodies in the scene that are not of the cast: where they are over time, whatever moves them."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ... import frames
from ...body.balls import Track
from ...errors import SampError
from ...pipeline.cast.cast_take import track
from ...pipeline.cast.directing import RATE
from ...pipeline.cast.role import Other
from ..actions import keyframes
from ..character import armature, character, characters
from ..scene import read_scene
from ..takes import seen

POINTS = 400
"""Points on the skin of each body."""

THICK = 0.03
"""Radius in metres of the balls at these."""

LONGEST = 120.0
"""Seconds of the scene that are looked at."""


def moving(
    context: bpy.types.Context,
    people: Sequence[bpy.types.Object],
    owners: Sequence[bpy.types.Object | None],
) -> list[bpy.types.Object]:
    """Return the armatures of other origin that move a skinned mesh over time. Those that stand still are furniture."""
    skinned = {obj.find_armature() for obj in context.scene.objects if obj.type == "MESH"} - {None}
    return [
        rig for rig in context.scene.objects
        if rig in skinned and rig not in people and rig not in owners and _animated(rig)
    ]  # fmt: skip


def present(
    context: bpy.types.Context,
    armatures: Sequence[bpy.types.Object],
    owners: Sequence[bpy.types.Object | None],
    first: int | None = None,
) -> list[Other]:
    """Return the bodies of those armatures that belong to none of them; see `read` for `first`.

    owners: characters that get takes. Rigs that takes were carried to show the body of another character once more.
    """
    rigs = [rig for rig in armatures if rig not in owners and not characters.is_carried_to(rig)]
    return read(context, rigs, first)


def read(
    context: bpy.types.Context, armatures: Sequence[bpy.types.Object], first: int | None = None
) -> list[Other]:
    """Return the bodies of armatures that are shown, from a frame to the last one in which an Action moves them.

    first: that frame; the scene's first one where left out.
    """
    bodies = [(rig, mesh) for rig in armatures for mesh in [_skin(context, rig)] if mesh is not None]
    first = context.scene.frame_start if first is None else first
    keyed = {rig.name: _keyed(context, rig, first) for rig, _ in bodies}
    evaluated = [(rig, mesh) for rig, mesh in bodies if keyed[rig.name] is None]
    found = keyed | {other.name: other for other in _evaluated(context, evaluated, first)}
    return [found[rig.name] for rig, _ in bodies]


def _keyed(context: bpy.types.Context, rig: bpy.types.Object, first: int) -> Other | None:
    """Return the body of an SMPL-X armature that only its active Action moves, without evaluating any frame; None for
    other armatures."""
    data = rig.animation_data
    if not armature.is_smplx(rig) or data is None or data.action is None or seen.influence(rig) is not None:
        return None
    try:
        motion = keyframes.read_motion(rig, data.action, scene=context.scene)
    except SampError:  # not all of the pose is keyed
        return None
    begin = int(np.floor(data.action.frame_range[0]))
    shown = track(motion, character.body_of(rig), RATE)
    late = round((begin - first) / motion.fps * RATE)
    rows = np.clip(np.arange(max(len(shown) + late, 1)) - late, 0, len(shown) - 1)
    rows = rows[: _samples(LONGEST * motion.fps, motion.fps)]
    return Other(rig.name, Track(shown.centres[rows], shown.radii, RATE), motion.root[-1])


def _evaluated(
    context: bpy.types.Context, bodies: Sequence[tuple[bpy.types.Object, bpy.types.Object]], first: int
) -> list[Other]:
    """Return bodies, each an armature with its skin, as Blender shows them frame by frame."""
    if not bodies:
        return []
    scene = context.scene
    per_second = scene.render.fps / scene.render.fps_base
    ends = {rig.name: _last_frame(rig, first) for rig, _ in bodies}
    count = {name: _samples(end - first, per_second) for name, end in ends.items()}
    kept = {rig.name: np.empty((count[rig.name], POINTS, 3)) for rig, _ in bodies}
    with seen.frame_kept(scene):
        for k in range(max(count.values())):
            frame = first + k * per_second / RATE
            scene.frame_set(int(frame), subframe=frame - int(frame))
            for rig, mesh in bodies:
                if k < count[rig.name]:
                    kept[rig.name][k] = _points(context, mesh)
    radii = np.full(POINTS, THICK)
    return [
        Other(rig.name, Track(kept[rig.name], radii, RATE), _pelvis(kept[rig.name][-1]))
        for rig, _ in bodies
    ]  # fmt: skip


def _samples(length: float, per_second: float) -> int:
    return int(np.clip(length / per_second, 0, LONGEST) * RATE) + 1


def _pelvis(points: np.ndarray) -> np.ndarray:
    """Return about where the pelvis of a body with these points (N, 3) is: under the middle of the trunk."""
    middle = np.median(points, axis=0)
    return np.array([middle[0], min(middle[1], points[:, 1].min() + 1.0), middle[2]])


def _animated(rig: bpy.types.Object) -> bool:
    data = rig.animation_data
    return data is not None and (data.action is not None or len(data.nla_tracks) > 0)


def _last_frame(rig: bpy.types.Object, first: int) -> float:
    data = rig.animation_data
    if data is None:
        return first
    ends = [strip.frame_end for track in data.nla_tracks for strip in track.strips]
    if data.action is not None:
        ends.append(data.action.frame_range[1])
    return max([first, *ends])


def _skin(context: bpy.types.Context, rig: bpy.types.Object) -> bpy.types.Object | None:
    """Return the largest mesh that an armature deforms and that the viewport and a render show."""
    found = [
        obj
        for obj in read_scene.with_dependants(context, [rig])
        if obj.type == "MESH" and obj.find_armature() == rig and not obj.hide_render and obj.visible_get()
    ]
    return max(found, key=lambda obj: len(obj.data.vertices), default=None)


def _points(context: bpy.types.Context, mesh: bpy.types.Object) -> np.ndarray:
    """Return points (POINTS, 3) of an evaluated skin, network frame; the same vertices in each frame."""
    shown = mesh.evaluated_get(context.evaluated_depsgraph_get())
    data = shown.to_mesh()
    try:
        points = np.empty(3 * len(data.vertices), np.float32)
        data.vertices.foreach_get("co", points)
    finally:
        shown.to_mesh_clear()
    chosen = points.reshape(-1, 3)[np.linspace(0, len(points) // 3 - 1, POINTS).astype(int)]
    world = np.array(shown.matrix_world, dtype=np.float64)
    return frames.to_network(chosen @ world[:3, :3].T + world[:3, 3])
