"""The content of a .blend file as plain values that can be compared.

Everything is read through Blender's RNA, so that new kinds of data are included. Derived values and data of the
window are left out.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable

import bpy
import numpy as np

# Data-blocks of the window and of Blender itself.
EXCLUDED = {"screens", "window_managers", "workspaces", "brushes", "palettes", "paint_curves"}
OWN_LIBRARIES = "essentials_"  # brush files that Blender links and unlinks when modes change
DERIVED = {
    *("rna_type", "bl_rna", "id_data", "original", "users", "tag", "session_uid", "preview", "depsgraph"),
    *("is_evaluated", "is_runtime_data", "is_missing", "library_weak_reference", "bound_box", "dimensions"),
    *("matrix", "matrix_basis", "matrix_channel", "head", "tail", "length", "center", "vector"),
    *("loop_triangles", "loop_triangle_polygons", "vertex_normals", "polygon_normals", "corner_normals"),
    *("attributes", "color_attributes", "sculpt_vertex_colors", "vertex_colors", "uv_layers", "edge_keys"),
    *("corner_verts", "fcurve_bones", "last_reuse_node", "is_updated", "is_updated_data", "edit_bones"),
    *("shading", "sequencer_colorspace_settings", "linear_colorspace_settings", "colorspace_settings"),
    *("use_nodes", "frame_current_final", "frame_float", "active_operator", "last_reports"),
    *("all_objects", "children_recursive", "uv_layer_stencil", "uv_layer_clone"),
    # Brushes of the tools: Blender's own, and in 4.2 dangling pointers.
    *("particle_edit", "paint_mode", "image_paint", "sculpt", "vertex_paint", "weight_paint", "uv_sculpt"),
    *("gpencil_paint", "gpencil_vertex_paint", "gpencil_sculpt_paint", "gpencil_weight_paint"),
    *("curves_sculpt", "gpencil_sculpt", "gpencil_interpolate"),
}
EVALUATED = {"matrix_world", "matrix_local"}  # of objects, once they are shown; stale while they are hidden
# Long arrays: (type, collection) -> property, type and width of each element.
BULK = {
    ("Mesh", "vertices"): ("co", np.float32, 3),
    ("Mesh", "edges"): ("vertices", np.int32, 2),
    ("Mesh", "loops"): ("vertex_index", np.int32, 1),
    ("Mesh", "polygons"): ("material_index", np.int32, 1),
    ("ShapeKey", "data"): ("co", np.float32, 3),
    ("ShapeKey", "points"): ("co", np.float32, 3),
    ("FCurve", "keyframe_points"): ("co", np.float32, 2),
    ("FCurve", "sampled_points"): ("co", np.float32, 2),
}


def taken() -> dict[str, object]:
    """Return every value of every data-block by path, and mode, selection and scene of the context."""
    found: dict[str, object] = {}
    for layer in (layer for scene in bpy.data.scenes for layer in scene.view_layers):
        layer.update()
    for kind in _kinds():
        for block in getattr(bpy.data, kind):
            if kind == "libraries" and block.name.startswith(OWN_LIBRARIES):
                continue
            path = f"{kind}/{block.name_full}"
            found[path] = kind
            _properties(found, path, block, set())
            found[f"{path}[custom]"] = _custom(block)
    found["context.mode"] = bpy.context.mode
    found["context.scene"] = bpy.context.scene.name
    for scene in bpy.data.scenes:
        for layer in scene.view_layers:
            active = layer.objects.active
            place = f"{scene.name}/{layer.name}"
            found[f"{place}.active"] = active and active.name
            for thing in layer.objects:
                found[f"{place}.shown/{thing.name}"] = (
                    thing.select_get(view_layer=layer),
                    thing.hide_get(view_layer=layer),
                    thing.mode,
                )
    return found


def differences(
    before: dict[str, object], after: dict[str, object], allowed: Iterable[str] = (), additions: bool = True
) -> list[str]:
    """Return the differences, one line each. additions: whether new data are allowed.

    allowed: patterns of paths that may change.
    """
    free = re.compile("|".join(allowed)) if allowed else None
    paths = list(before) if additions else [*before, *(path for path in after if path not in before)]
    missing = object()
    if additions:
        # A list may grow; what was in it before is compared one by one.
        paths = [path for path in paths if not path.endswith(".length") or after.get(path, -1) < before[path]]
    return [
        f"{path}: {before.get(path, 'nothing')!s:.80} -> {after.get(path, 'nothing')!s:.80}"
        for path in paths
        if before.get(path, missing) != after.get(path, missing) and not (free and free.match(path))
    ]


def orphans() -> set[str]:
    """Return the data-blocks without users, by kind and name."""
    return {
        f"{kind}/{block.name_full}"
        for kind in _kinds()
        for block in getattr(bpy.data, kind)
        if block.users == 0 and kind != "libraries"
    }


def _kinds() -> list[str]:
    """Return the names of bpy.data's collections of user data."""
    found = [p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION"]
    return [kind for kind in found if kind not in EXCLUDED]


_MEMBERS: dict[str, list[tuple[str, str]]] = {}


def _members(struct: bpy.types.bpy_struct) -> list[tuple[str, str]]:
    """Return (name, type) of the properties of an RNA type that are not derived."""
    kind = struct.bl_rna.identifier
    if kind not in _MEMBERS:
        properties = struct.bl_rna.properties
        _MEMBERS[kind] = [(p.identifier, p.type) for p in properties if p.identifier not in DERIVED]
    return _MEMBERS[kind]


def _properties(found: dict, path: str, struct: bpy.types.bpy_struct, seen: set) -> None:
    me = struct.as_pointer(), struct.bl_rna.identifier
    if me in seen:  # parents and children refer to each other
        found[path] = getattr(struct, "name", "seen")
        return
    seen.add(me)
    kind = me[1]
    for name, sort in _members(struct):
        try:
            value = getattr(struct, name)
        except (AttributeError, RuntimeError, ValueError):
            continue  # not readable in this state
        where = f"{path}.{name}"
        if kind == "Object" and name in EVALUATED and struct.hide_viewport:
            value = None
        if sort == "POINTER":
            _pointer(found, where, value, seen)
        elif sort == "COLLECTION":
            _collection(found, where, (kind, name), value, seen)
        else:
            found[where] = _plain(value)


def _pointer(found: dict, path: str, value: object, seen: set) -> None:
    if value is None:
        found[path] = None
    elif isinstance(value, bpy.types.ID) and not value.is_embedded_data:
        found[path] = value.name_full
    else:
        _properties(found, path, value, seen)


def _collection(found: dict, path: str, kind: tuple[str, str], values: object, seen: set) -> None:
    if kind in BULK:
        name, sort, width = BULK[kind]
        numbers = np.empty(len(values) * width, dtype=sort)
        values.foreach_get(name, numbers)
        found[path] = len(values), hashlib.sha1(numbers.tobytes()).hexdigest()[:12]
        return
    found[f"{path}.length"] = len(values)
    for number, value in enumerate(values):
        where = f"{path}[{getattr(value, 'name', number)!s}]"
        if isinstance(value, bpy.types.ID):
            found[where] = value.name_full
        else:
            _properties(found, where, value, seen)
            if hasattr(value, "keys") and isinstance(value, bpy.types.PoseBone):
                found[f"{where}[custom]"] = _custom(value)


def _plain(value: object) -> object:
    """Return a copy of a value in which NaN equals itself."""
    if isinstance(value, float) and math.isnan(value):
        return "nan"
    if isinstance(value, bool | int | float | str | bytes | None):
        return value
    if isinstance(value, set):
        return tuple(sorted(value))
    try:
        return tuple(_plain(part) for part in value)
    except TypeError:
        return str(value)


def _custom(block: bpy.types.bpy_struct) -> str:
    """Return custom properties as text."""
    found = {}
    for key in sorted(block.keys()):
        if key in block.bl_rna.properties:
            continue  # before Blender 5 an add-on's registered properties are stored here, and are read as such
        value = block[key]
        reader = getattr(value, "to_dict", None) or getattr(value, "to_list", None)
        found[key] = reader() if reader else getattr(value, "name_full", value)
    return repr(found)
