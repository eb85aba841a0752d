"""Reads Blender's scene as triangles in the network frame: what a render would show, without characters."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from dataclasses import dataclass

import bpy
import numpy as np

from ...errors import SampError
from ...scene import geometry
from ...scene.geometry import SceneGeometry
from . import meshes
from .candidates import OVERLAY_KEY
from .regions import Region, find_region

CUSHION_KEY = "samp_cushion"
"""Custom property of an object: metres that it yields under a body; 0 if missing."""

SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


@dataclass(frozen=True)
class Target:
    """A piece of furniture. triangles: (F, 3, 3) metres, network frame. parts: the names of its objects. hint: a point
    (3,) on the part of a joined room that was named, or None."""

    name: str
    triangles: np.ndarray
    parts: tuple[str, ...]
    hint: np.ndarray | None = None


@dataclass(frozen=True)
class Member:
    """An object inside a collection instance, such as a sofa of a linked set."""

    instancer: bpy.types.Object
    obj: bpy.types.Object

    @property
    def name(self) -> str:
        """INSTANCE/MEMBER, as the pieces of a scene are named."""
        return f"{self.instancer.name}/{self.obj.name}"


def read_scene(context: bpy.types.Context, exclude: Iterable[bpy.types.Object] = ()) -> SceneGeometry:
    """Return the world-space triangles of all objects of the active view layer that a render shows.

    Modifiers, instances, collection instances and parents are applied. Objects that are hidden in the viewport only
    are read without their modifiers. Objects of ``exclude`` are left out with their children and skinned meshes, and
    so are collision hulls, fog and scattered blades. An instance has the name of its instancer, a member of a
    collection instance INSTANCE/MEMBER. Raise SampError, naming the object, for NaN.
    """
    left_out = with_dependants(context, exclude)
    return SceneGeometry.from_objects(
        meshes.gather(context, lambda owner: owner not in left_out, hidden=True)
    )


def cushion_depths(context: bpy.types.Context, names: Iterable[str]) -> np.ndarray:
    """Return the cushion depth (N,) in metres of objects by name. Raise SampError for an invalid depth."""
    members = _members_by_name(context)
    return np.array([_cushion_of(context, name, members) for name in names], dtype=np.float64)


def _cushion_of(context: bpy.types.Context, name: str, members: dict[str, Member]) -> float:
    if name in context.scene.objects:
        return _cushion(context.scene.objects[name])
    if name not in members:
        return 0.0
    shown = members[name]
    collection = shown.instancer.instance_collection
    of_all = _depth(collection) if CUSHION_KEY in collection else 0.0
    return _cushion(shown.obj, inherit=True) or _cushion(shown.instancer, inherit=True) or of_all


def _cushion(obj: bpy.types.Object, inherit: bool = False) -> float:
    """Return an object's own depth, or its nearest parent's; else the largest in a collection that it instances.

    inherit: do not look into the collection.
    """
    holder = obj
    while holder is not None:
        if CUSHION_KEY in holder:
            return _depth(holder)
        holder = holder.parent
    if inherit or obj.instance_type != "COLLECTION" or obj.instance_collection is None:
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
    hint = None
    if isinstance(found, Region):
        hint, found = found.point, found.obj
    if isinstance(found, Member):
        inside = _families([found.obj])
        pieces = meshes.gather(context, lambda owner: owner == found.instancer, inside)
        parts = {found.instancer}
    else:
        parts = _members(found) - with_dependants(context, exclude)
        pieces = meshes.gather(context, lambda owner: owner in parts)
    if not pieces:
        _raise_nothing_read(context, found, parts)
    scene = SceneGeometry.from_objects(pieces)
    geometry.require_surface(scene.triangles, found.name)
    return Target(found.name, scene.triangles, scene.names, hint)


def find_member(context: bpy.types.Context, name: str) -> Member | None:
    """Return the member of a collection instance by INSTANCE/MEMBER, or by its own name where only one has it."""
    members = _members_by_name(context)
    same = [member for member in members.values() if member.obj.name == name]
    return members.get(name) or (same[0] if len(same) == 1 else None)


def _members_by_name(context: bpy.types.Context) -> dict[str, Member]:
    """Return INSTANCE/MEMBER -> member for all collection instances of the scene."""
    instancers = [
        o for o in context.scene.objects if o.instance_type == "COLLECTION" and o.instance_collection
    ]
    found = (Member(owner, obj) for owner in instancers for obj in _everything(owner.instance_collection))
    return {member.name: member for member in found}


def _everything(collection: bpy.types.Collection) -> list[bpy.types.Object]:
    """Return the objects of a collection and of the collections that these instance."""
    found, waiting = {}, [collection]
    while waiting:
        for obj in waiting.pop().all_objects:
            if obj not in found:
                found[obj] = None
                if obj.instance_type == "COLLECTION" and obj.instance_collection is not None:
                    waiting.append(obj.instance_collection)
    return list(found)


def find_target(
    context: bpy.types.Context, name: str
) -> bpy.types.Object | bpy.types.Collection | Member | Region:
    """Return the object or collection of this name, or the member of a collection instance, INSTANCE/MEMBER.

    OBJECT/NAME is the part of a mesh with the material or vertex group of this name. Raise SampError with close names
    where there is none.
    """
    objects = context.scene.objects
    collections = {c.name: c for c in context.scene.collection.children_recursive}
    found = objects.get(name) or collections.get(name)
    if found is not None:
        return found
    found = find_member(context, name) or find_region(context, name)
    if found is not None:
        return found
    known = [o.name for o in objects if not o.get(OVERLAY_KEY)] + list(collections)
    known += _members_by_name(context)
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


def _raise_nothing_read(
    context: bpy.types.Context,
    target: bpy.types.Object | bpy.types.Collection | Member,
    parts: set[bpy.types.Object],
) -> None:
    if parts and all(map(meshes.is_hull, parts)):
        raise SampError(
            f"'{target.name}' is a collision hull and not furniture; choose the object it encloses."
        )
    rendered = meshes.rendered_objects(context.scene.collection)
    solid = (o for o in parts if o.type in SURFACE_TYPES or o.instance_type == "COLLECTION")
    if any(o not in rendered or not o.visible_get(view_layer=context.view_layer) for o in solid):
        raise SampError(f"'{target.name}' is hidden in the viewport or in renders; show it in both.")
    raise SampError(f"'{target.name}' has no faces; choose an object, an empty or a collection with some.")
