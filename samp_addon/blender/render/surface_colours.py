"""The base colour of each object, linear."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ..scene import read_scene

GREY = (0.5, 0.5, 0.5)
TEXTURED = (0.35, 0.32, 0.28)
"""Of surfaces whose colour comes from a texture, and that have no viewport colour of their own."""


def of_objects(context: bpy.types.Context, names: Sequence[str]) -> np.ndarray:
    """Return the colours (N, 3) of objects, or members of collection instances, by name."""
    found = [_colour(_object(context, name)) for name in names]
    return np.array(found, dtype=np.float64).reshape(-1, 3)


def _object(context: bpy.types.Context, name: str) -> bpy.types.Object | None:
    own = context.scene.objects.get(name)
    if own is not None:
        return own
    member = read_scene.find_member(context, name)
    return None if member is None else member.obj


def _colour(obj: bpy.types.Object | None) -> tuple[float, float, float]:
    """Return the colour of the material that most faces of an object have."""
    if obj is None or not obj.material_slots:
        return GREY
    index = 0
    if obj.type == "MESH" and len(obj.material_slots) > 1 and len(obj.data.polygons):
        used = np.zeros(len(obj.data.polygons), np.int32)
        obj.data.polygons.foreach_get("material_index", used)
        index = min(int(np.bincount(used).argmax()), len(obj.material_slots) - 1)
    material = obj.material_slots[index].material
    return GREY if material is None else _of_material(material)


def _of_material(material: bpy.types.Material) -> tuple[float, float, float]:
    """Return the base colour of a material's surface shader, else its viewport colour."""
    shown = tuple(material.diffuse_color[:3])
    nodes = material.node_tree.nodes if material.node_tree is not None else ()
    for node in nodes:
        socket = node.inputs.get("Base Color") or (
            node.inputs.get("Color") if node.type != "TEX_IMAGE" else None
        )
        if node.type.startswith("BSDF") and socket is not None:
            if not socket.is_linked:
                return tuple(socket.default_value[:3])
            plain = all(abs(value - 0.8) < 1e-3 for value in shown)
            return TEXTURED if plain else shown
    return shown
