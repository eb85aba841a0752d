"""The ghost body at a sub-goal: a mesh below the arrow that is never rendered and cannot be selected."""

from __future__ import annotations

import bpy
import numpy as np

from ... import frames
from ...body import human, proportions
from ...motion import Motion
from ..character import armature, character
from ..scene.candidates import OVERLAY_KEY
from . import arrows

GHOST_KEY = "samp_ghost"
"""Custom property of an arrow: its ghost; of a ghost: True."""
COLOURS = {"body": (0.35, 0.62, 1.0, 0.5), "pinned": (1.0, 0.75, 0.3, 0.5), "misplaced": (1.0, 0.2, 0.2, 0.5)}
"""Colours of bodies that may be drawn again, of pinned ones, and of those at places that cannot be used."""


def show(context: bpy.types.Context, arrow: bpy.types.Object, pose: Motion, look: str) -> bpy.types.Object:
    """Show a pose (one frame, network frame) as the ghost of an arrow, in its character's shape.

    look: a key of COLOURS.
    """
    owner = arrows.owner_of(arrow)
    body, rest = character.body_of(owner), armature.calibrate(owner).rest_joints
    points = frames.to_blender(human.skin(body, proportions.adapt(pose, rest))[0])
    inverse = np.linalg.inv(np.array(arrow.matrix_world, dtype=np.float64))
    local = points @ inverse[:3, :3].T + inverse[:3, 3]
    ghost = find(arrow) or _create(context, arrow)
    mesh = ghost.data
    if len(mesh.vertices) != len(local):
        mesh.clear_geometry()
        faces = [face[:3] if face[2] == face[3] else face for face in body.faces.tolist()]
        mesh.from_pydata(local.tolist(), [], faces)
        mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), dtype=bool))
    else:
        mesh.vertices.foreach_set("co", local.astype(np.float32).ravel())
    mesh.update()
    colour(arrow, look)
    return ghost


def colour(arrow: bpy.types.Object, look: str) -> None:
    """Colour the ghost of an arrow. look: a key of COLOURS."""
    ghost = find(arrow)
    if ghost is None:
        return
    ghost.color = COLOURS[look]
    before = [material for material in ghost.data.materials if material is not None]
    material = _material(look)
    if ghost.data.materials:
        ghost.data.materials[0] = material
    else:
        ghost.data.materials.append(material)
    _drop_unused(before)


def find(arrow: bpy.types.Object) -> bpy.types.Object | None:
    """Return the ghost of an arrow; None also for a copied arrow, which points to the ghost of its original."""
    ghost = arrow.get(GHOST_KEY)
    return ghost if isinstance(ghost, bpy.types.Object) and ghost.parent == arrow else None


def is_ghost(obj: bpy.types.Object) -> bool:
    """Return whether an object is a ghost."""
    return obj.type == "MESH" and GHOST_KEY in obj


def orphans(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """Return the ghosts whose arrows were deleted."""
    home = arrows.collection(scene)
    if home is None:
        return []
    there = set(scene.objects)
    return [obj for obj in home.objects if is_ghost(obj) and obj.parent not in there]


def remove(ghost: bpy.types.Object) -> None:
    """Delete a ghost with its mesh, and materials that nothing uses any more."""
    mesh = ghost.data
    materials = [material for material in mesh.materials if material is not None]
    bpy.data.objects.remove(ghost)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)
    _drop_unused(materials)


def _create(context: bpy.types.Context, arrow: bpy.types.Object) -> bpy.types.Object:
    name = f"Body of {arrow.name}"
    ghost = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    ghost[OVERLAY_KEY] = ghost[GHOST_KEY] = True
    ghost.hide_render, ghost.hide_select = True, True
    ghost.parent = arrow
    arrow[GHOST_KEY] = ghost
    arrows.home(context).objects.link(ghost)
    return ghost


def _drop_unused(materials: list[bpy.types.Material]) -> None:
    for material in set(materials):
        if material.users == 0:
            bpy.data.materials.remove(material)


def _material(look: str) -> bpy.types.Material:
    """Return the material of ghosts of a look, which the solid viewport shows."""
    name = f"SAMP ghost {look}"
    found = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    found.diffuse_color = COLOURS[look]
    return found
