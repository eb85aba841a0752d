"""Reads Blender's scene as triangles in the network frame: what a render would show, without characters."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames
from ...errors import SampError
from ...scene import geometry
from ...scene.geometry import SceneGeometry

OVERLAY_KEY = "samp_overlay"
"""Custom property of overlay objects of this add-on; they are never part of the scene."""

CUSHION_KEY = "samp_cushion"
"""Custom property of an object: metres that it yields under a body; 0 if missing."""

SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


@dataclass(frozen=True)
class Target:
    """A piece of furniture. triangles: (F, 3, 3) metres, network frame. parts: the names of its objects."""

    name: str
    triangles: np.ndarray
    parts: tuple[str, ...]


def read_scene(context: bpy.types.Context, exclude: Iterable[bpy.types.Object] = ()) -> SceneGeometry:
    """Return the world-space triangles of all objects visible in the active view layer and in renders.

    Modifiers, instances, collection instances and parents are applied. Objects of ``exclude`` are left out with
    their children and skinned meshes. An instance has the name of its instancer. Raise SampError, naming the
    object, for NaN.
    """
    left_out = with_dependants(context, exclude)
    return SceneGeometry.from_objects(_gather(context, lambda owner: owner not in left_out))


def cushion_depths(context: bpy.types.Context, names: Iterable[str]) -> np.ndarray:
    """Return the cushion depth (N,) in metres of objects by name. Raise SampError for an invalid depth."""
    objects = context.scene.objects
    return np.array([_cushion(objects[name]) if name in objects else 0.0 for name in names], dtype=np.float64)


def _cushion(obj: bpy.types.Object) -> float:
    """Return an object's own depth, or its nearest parent's; else the largest in a collection that it instances."""
    holder = obj
    while holder is not None:
        if CUSHION_KEY in holder:
            return _depth(holder)
        holder = holder.parent
    if obj.instance_type != "COLLECTION" or obj.instance_collection is None:
        return 0.0
    shown = (obj.instance_collection, *obj.instance_collection.all_objects)
    return max((_depth(part) for part in shown if CUSHION_KEY in part), default=0.0)


def _depth(holder: bpy.types.ID) -> float:
    depth = holder[CUSHION_KEY]
    if not isinstance(depth, int | float) or not math.isfinite(depth) or depth < 0:
        raise SampError(f"The cushion depth of '{holder.name}' is not a valid length; set it with Soft Seat.")
    return float(depth)


def read_target(
    context: bpy.types.Context,
    target: str | bpy.types.Object | bpy.types.Collection,
    exclude: Iterable[bpy.types.Object] = (),
) -> Target:
    """Read an object with its children, an empty, or a collection as furniture. target: its name, or itself.

    Raise SampError where the name is unknown (with close names), or the target is hidden or has no surface.
    """
    found = find_target(context, target) if isinstance(target, str) else target
    parts = _members(found) - with_dependants(context, exclude)
    pieces = _gather(context, lambda owner: owner in parts)
    if not pieces:
        _raise_nothing_read(context, found, parts)
    scene = SceneGeometry.from_objects(pieces)
    geometry.require_surface(scene.triangles, found.name)
    return Target(found.name, scene.triangles, scene.names)


def find_target(context: bpy.types.Context, name: str) -> bpy.types.Object | bpy.types.Collection:
    """Return the object or collection of this name. Raise SampError with close names where there is none."""
    objects = context.scene.objects
    collections = {c.name: c for c in context.scene.collection.children_recursive}
    found = objects.get(name) or collections.get(name)
    if found is not None:
        return found
    known = [o.name for o in objects if not o.get(OVERLAY_KEY)] + list(collections)
    close = close_names(name, known)
    if close:
        raise SampError(f"There is no '{name}' in the scene; did you mean {close}?")
    some = ", ".join(f"'{k}'" for k in known[:5]) + (", ..." if len(known) > 5 else "")
    advice = f"choose one of {some}" if some else "it is empty, so add the furniture first"
    raise SampError(f"There is no '{name}' in the scene; {advice}.")


def close_names(name: str, known: Iterable[str]) -> str:
    """Return up to five known names similar to ``name``, for an error message; empty where there are none."""
    lower = {k.lower(): k for k in known}
    near = difflib.get_close_matches(name.lower(), lower, n=5, cutoff=0.5)
    near += [k for k in lower if name.lower() in k and k not in near]
    return ", ".join(f"'{lower[k]}'" for k in near[:5])


def with_dependants(context: bpy.types.Context, objects: Iterable[bpy.types.Object]) -> set[bpy.types.Object]:
    """Return the objects, their children and the meshes that their armatures deform."""
    found = _families(objects)
    armatures = {obj for obj in found if obj.type == "ARMATURE"}
    if not armatures:
        return found
    skinned = (
        obj
        for obj in context.scene.objects
        if any(m.type == "ARMATURE" and m.object in armatures for m in obj.modifiers)
    )
    return found | _families(skinned)


def _members(target: bpy.types.Object | bpy.types.Collection) -> set[bpy.types.Object]:
    return _families(target.all_objects if isinstance(target, bpy.types.Collection) else (target,))


def _families(roots: Iterable[bpy.types.Object]) -> set[bpy.types.Object]:
    """Return the objects with all their descendants."""
    # children_recursive scans all objects at each call; one pass serves thousands of roots.
    children: dict[bpy.types.Object, list[bpy.types.Object]] = {}
    for obj in bpy.data.objects:
        if obj.parent:
            children.setdefault(obj.parent, []).append(obj)
    found, waiting = set(), list(roots)
    while waiting:
        obj = waiting.pop()
        if obj not in found:
            found.add(obj)
            waiting += children.get(obj, ())
    return found


def _gather(
    context: bpy.types.Context, wanted: Callable[[bpy.types.Object], bool]
) -> list[tuple[str, np.ndarray]]:
    """Return (name, triangles in the network frame) of each accepted original object with faces."""
    pieces: dict[str, list[np.ndarray]] = {}
    for owner, instance, renderable in _shown_meshes(context):
        if renderable and wanted(owner):
            points, corners = _local_mesh(instance.object, owner)
            if len(corners):
                pieces.setdefault(owner.name, []).append(_transform(points, corners, instance.matrix_world))
    return [(name, np.concatenate(parts)) for name, parts in pieces.items()]


def _shown_meshes(
    context: bpy.types.Context,
) -> Iterator[tuple[bpy.types.Object, bpy.types.DepsgraphObjectInstance, bool]]:
    """Yield (original owner, instance, whether a render shows it) of each mesh visible in the view layer.

    Curves, text, metaballs and surfaces appear as instances of their evaluated meshes.
    """
    rendered = _rendered_objects(context.scene.collection)
    inside: dict[bpy.types.Collection, set[bpy.types.Object]] = {}
    for instance in context.evaluated_depsgraph_get().object_instances:
        if instance.object.type != "MESH" or not instance.show_self:
            continue
        owner = (instance.parent if instance.is_instance else instance.object).original
        if owner.get(OVERLAY_KEY):
            continue
        renderable = owner in rendered
        if renderable and instance.is_instance and owner.instance_type == "COLLECTION":
            collection = owner.instance_collection
            if collection not in inside:
                inside[collection] = _rendered_objects(collection, follow=True)
            renderable = instance.object.original in inside[collection]
        yield owner, instance, renderable


def _rendered_objects(collection: bpy.types.Collection, follow: bool = False) -> set[bpy.types.Object]:
    """Return objects below a collection that are enabled in renders; ``follow`` enters collection instances."""
    if collection.hide_render:
        return set()
    found = {obj for obj in collection.objects if not obj.hide_render}
    for obj in tuple(found) if follow else ():
        if obj.instance_type == "COLLECTION" and obj.instance_collection:
            found |= _rendered_objects(obj.instance_collection, follow)
    for child in collection.children:
        found |= _rendered_objects(child, follow)
    return found


def _local_mesh(evaluated: bpy.types.Object, owner: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (V, 3) of an evaluated mesh object in local space, and triangle corners (F, 3)."""
    if owner.mode != "EDIT":
        return _read_mesh(evaluated.data)
    # In edit mode the evaluated mesh only wraps the edit mesh.
    try:
        return _read_mesh(evaluated.to_mesh())
    finally:
        evaluated.to_mesh_clear()


def _read_mesh(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    mesh.calc_loop_triangles()
    points = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    corners = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
    mesh.vertices.foreach_get("co", points.ravel())
    mesh.loop_triangles.foreach_get("vertices", corners.ravel())
    return points, corners


def _transform(points: np.ndarray, corners: np.ndarray, matrix: object) -> np.ndarray:
    """Return triangles (F, 3, 3) in the network frame of a mesh with its object's matrix."""
    world = np.array(matrix, dtype=np.float64)
    # One product applies both the object's matrix and the change of axes; there may be millions of vertices.
    turned = frames.to_network(world[:3, :3].T)
    # Reverse the winding of mirrored objects, so that normals still point outwards.
    corners = corners[:, ::-1] if np.linalg.det(turned) < 0 else corners
    return (points @ turned + frames.to_network(world[:3, 3])).take(corners, axis=0)


def _raise_nothing_read(
    context: bpy.types.Context,
    target: bpy.types.Object | bpy.types.Collection,
    parts: set[bpy.types.Object],
) -> None:
    rendered = _rendered_objects(context.scene.collection)
    solid = (o for o in parts if o.type in SURFACE_TYPES or o.instance_type == "COLLECTION")
    if any(o not in rendered or not o.visible_get(view_layer=context.view_layer) for o in solid):
        raise SampError(f"'{target.name}' is hidden in the viewport or in renders; show it in both.")
    raise SampError(f"'{target.name}' has no faces; choose an object, an empty or a collection with some.")
