"""The piece of furniture that a target's name means: with what rests on it, or the part of a room."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ...scene.furniture import parts, room
from ...scene.furniture.belongings import belongings
from ...scene.geometry import SceneGeometry
from .read_scene import Target


def piece(
    context: bpy.types.Context,
    geometry: SceneGeometry,
    target: Target,
    action: str,
    point: np.ndarray | None = None,
) -> tuple[SceneGeometry, Target]:
    """Return the target with all that belongs to it; of a whole room, the piece that is meant.

    point: (3,) on that piece, network frame, as under a click; without one, it is the piece with the best place.
    """
    mine = geometry.is_one_of(target.parts)
    if target.hint is not None or parts.is_room(geometry.triangles[mine], geometry.object_ids[mine]):
        hint = target.hint if point is None else point
        chosen = room.choose(geometry, target.parts, action, hint)
        if chosen is not None:
            name = f"{target.name} (part)"
            geometry = geometry.renamed(chosen, name)
            target = replace(target, triangles=geometry.triangles[chosen], parts=(name,))
        return geometry, target
    more = belongings(geometry, target.parts, characters(context))
    if more:
        names = (*target.parts, *more)
        target = replace(target, triangles=geometry.triangles_of(names), parts=names)
    return geometry, target


def characters(context: bpy.types.Context) -> dict[str, str]:
    """Return the names of skinned meshes, each with that of the armature that moves it."""
    owners = ((obj.name, obj.find_armature()) for obj in context.scene.objects if obj.type == "MESH")
    return {name: owner.name for name, owner in owners if owner is not None}
