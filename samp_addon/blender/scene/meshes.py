"""Reads the meshes that a render shows as triangles in the network frame, one piece per object."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import bpy
import numpy as np

from ... import frames
from ...scene.furniture import scatter
from .candidates import OVERLAY_KEY

HULLS = ("UCX_", "UBX_", "USP_", "UCP_")
"""Prefixes of collision hulls of game engines, which enclose furniture and are not rendered there."""

MANY = 50
"""Copies of a tiny mesh by one instancer from which on they are scattered, such as blades of grass."""

Accept = Callable[[bpy.types.Object], bool]


def gather(
    context: bpy.types.Context,
    wanted: Accept,
    members: set[bpy.types.Object] | None = None,
    hidden: bool = False,
) -> list[tuple[str, np.ndarray]]:
    """Return (name, triangles in the network frame) of each accepted original object with faces.

    Members of a collection instance are named INSTANCE/MEMBER. members: of collection instances, only these. hidden:
    also what a render shows though the viewport does not.
    """
    pieces: dict[str, list[np.ndarray]] = {}
    tiny = _Scattered()
    for owner, instance, renderable in _shown_meshes(context):
        if (
            not renderable
            or not wanted(owner)
            or (members is not None and _member(owner, instance) not in members)
        ):
            continue
        name = _name(owner, instance)
        if instance.is_instance and owner.instance_type != "COLLECTION" and tiny.skip(name, instance):
            continue
        points, corners = _local_mesh(instance.object, owner)
        corners = scatter.without_blades(points, corners, scatter.scale_of(np.array(instance.matrix_world)))
        if len(corners):
            pieces.setdefault(name, []).append(_transform(points, corners, instance.matrix_world))
            tiny.note(name, instance, pieces[name])
    tiny.drop(pieces)
    if hidden:
        for owner in _hidden_but_rendered(context):
            if wanted(owner):
                points, corners = _read_mesh(owner.data)
                if len(corners):
                    pieces.setdefault(owner.name, []).append(_transform(points, corners, _placed(owner)))
    return [(name, np.concatenate(parts)) for name, parts in pieces.items() if parts]


def is_hull(obj: bpy.types.Object) -> bool:
    """Return whether an object is a collision hull by its name."""
    return obj.name.startswith(HULLS)


@dataclass
class _Scattered:
    """Instances of meshes that consist of tiny parts, counted for each instancer."""

    tiny: dict[int, bool] = field(default_factory=dict)
    count: dict[tuple[str, int], int] = field(default_factory=dict)
    kept: dict[tuple[str, int], list[tuple[list, np.ndarray]]] = field(default_factory=dict)

    def skip(self, name: str, instance: bpy.types.DepsgraphObjectInstance) -> bool:
        """Return whether this instance is one of many tiny ones."""
        mesh = instance.object.data.as_pointer()
        if mesh not in self.tiny:
            self.tiny[mesh] = scatter.is_tiny(
                *_read_mesh(instance.object.data), scatter.scale_of(np.array(instance.matrix_world))
            )
        key = name, mesh
        self.count[key] = self.count.get(key, 0) + 1
        return self.tiny[mesh] and self.count[key] > MANY

    def note(self, name: str, instance: bpy.types.DepsgraphObjectInstance, parts: list[np.ndarray]) -> None:
        """Remember the triangles that were read last."""
        if instance.is_instance and self.tiny.get(instance.object.data.as_pointer()):
            self.kept.setdefault((name, instance.object.data.as_pointer()), []).append((parts, parts[-1]))

    def drop(self, pieces: dict[str, list[np.ndarray]]) -> None:
        """Remove the first instances of what turned out to be scattered."""
        for key, found in self.kept.items():
            if self.count[key] > MANY:
                gone = {id(triangles) for _, triangles in found}
                pieces[key[0]][:] = [part for part in pieces[key[0]] if id(part) not in gone]


def _name(owner: bpy.types.Object, instance: bpy.types.DepsgraphObjectInstance) -> str:
    if instance.is_instance and owner.instance_type == "COLLECTION":
        return f"{owner.name}/{instance.object.original.name}"
    return owner.name


def _member(owner: bpy.types.Object, instance: bpy.types.DepsgraphObjectInstance) -> bpy.types.Object | None:
    shown = instance.is_instance and owner.instance_type == "COLLECTION"
    return instance.object.original if shown else None


def _shown_meshes(
    context: bpy.types.Context,
) -> Iterator[tuple[bpy.types.Object, bpy.types.DepsgraphObjectInstance, bool]]:
    """Yield (original owner, instance, whether a render shows it) of each mesh visible in the view layer.

    Curves, text, metaballs and surfaces appear as instances of their evaluated meshes.
    """
    rendered = rendered_objects(context.scene.collection)
    inside: dict[bpy.types.Collection, set[bpy.types.Object]] = {}
    hollow: dict[bpy.types.Object, bool] = {}
    for instance in context.evaluated_depsgraph_get().object_instances:
        if instance.object.type != "MESH" or not instance.show_self:
            continue
        owner = (instance.parent if instance.is_instance else instance.object).original
        if owner.get(OVERLAY_KEY):
            continue
        renderable = owner in rendered
        shown = instance.object.original
        if renderable and instance.is_instance and owner.instance_type == "COLLECTION":
            collection = owner.instance_collection
            if collection not in inside:
                inside[collection] = rendered_objects(collection, follow=True)
            renderable = shown in inside[collection]
        if shown not in hollow:
            hollow[shown] = is_hull(shown) or _only_volume(shown)
        yield owner, instance, renderable and not hollow[shown]


def rendered_objects(collection: bpy.types.Collection, follow: bool = False) -> set[bpy.types.Object]:
    """Return objects below a collection that are enabled in renders; ``follow`` enters collection instances."""
    if collection.hide_render:
        return set()
    found = {obj for obj in collection.objects if not obj.hide_render}
    for obj in tuple(found) if follow else ():
        if obj.instance_type == "COLLECTION" and obj.instance_collection:
            found |= rendered_objects(obj.instance_collection, follow)
    for child in collection.children:
        found |= rendered_objects(child, follow)
    return found


def _hidden_but_rendered(context: bpy.types.Context) -> Iterator[bpy.types.Object]:
    """Yield the meshes that a render shows though the viewport does not, such as the originals of proxies.

    Blender does not evaluate them in the viewport, so they are read without modifiers.
    """
    rendered = rendered_objects(context.scene.collection) - _bone_shapes(context)
    for obj in context.view_layer.objects:
        if obj.type != "MESH" or obj not in rendered or obj.visible_get(view_layer=context.view_layer):
            continue
        helper = obj.display_type in ("WIRE", "BOUNDS") or obj.get(OVERLAY_KEY) or is_hull(obj)
        if not helper and not _only_volume(obj):
            yield obj


def _bone_shapes(context: bpy.types.Context) -> set[bpy.types.Object]:
    """Return the objects that bones are drawn as; rigs hide them in the viewport only."""
    rigs = [obj for obj in context.scene.objects if obj.type == "ARMATURE" and obj.pose is not None]
    return {bone.custom_shape for rig in rigs for bone in rig.pose.bones if bone.custom_shape is not None}


def _placed(obj: bpy.types.Object) -> np.ndarray:
    """Return the matrix (4, 4) of an object that Blender has not evaluated."""
    own = np.array(obj.matrix_basis)
    if obj.parent is None:
        return own
    if obj.parent_type != "OBJECT":
        return np.array(obj.matrix_world)
    return _placed(obj.parent) @ np.array(obj.matrix_parent_inverse) @ own


def _only_volume(obj: bpy.types.Object) -> bool:
    """Return whether all materials of an object are volumes without a surface: fog, smoke."""
    materials = [slot.material for slot in obj.material_slots if slot.material is not None]
    return bool(materials) and all(map(_is_volume, materials))


def _is_volume(material: bpy.types.Material) -> bool:
    if material.node_tree is None:
        return False
    ends = [n for n in material.node_tree.nodes if n.type == "OUTPUT_MATERIAL" and n.is_active_output]
    return any(n.inputs["Volume"].is_linked and not n.inputs["Surface"].is_linked for n in ends)


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
    loops = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
    # Attributes are copied as a whole; vertices, loops and triangles are read one after the other.
    if len(points):
        mesh.attributes["position"].data.foreach_get("vector", points.ravel())
    if not len(loops):
        return points, loops
    vertices = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.attributes[".corner_vert"].data.foreach_get("value", vertices)
    if len(loops) == len(mesh.polygons):  # all are triangles
        return points, vertices.reshape(-1, 3)
    mesh.loop_triangles.foreach_get("loops", loops.ravel())
    return points, vertices[loops]


def _transform(points: np.ndarray, corners: np.ndarray, matrix: object) -> np.ndarray:
    """Return triangles (F, 3, 3) in the network frame of a mesh with its object's matrix."""
    world = np.array(matrix, dtype=np.float64)
    # One product applies both the object's matrix and the change of axes; there may be millions of vertices.
    turned = frames.to_network(world[:3, :3].T)
    # Reverse the winding of mirrored objects, so that normals still point outwards.
    corners = corners[:, ::-1] if np.linalg.det(turned) < 0 else corners
    return (points @ turned + frames.to_network(world[:3, 3])).take(corners, axis=0)
