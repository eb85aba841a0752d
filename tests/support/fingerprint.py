"""All that an artist's file holds, as plain values that can be compared: nothing of it may change by itself.

Everything is read through Blender's own description of its types, so that nothing has to be listed here and a new
kind of data is seen as well. What is left out is derived from the rest, or belongs to the window.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable

import bpy
import numpy as np

# Data-blocks of the window and of Blender itself.
NOT_THE_ARTISTS = {"screens", "window_managers", "workspaces", "brushes", "palettes", "paint_curves"}
OWN_LIBRARIES = (
    "essentials_"  # files of brushes that Blender links when a mode is entered, and drops by itself
)
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
    # Brushes of the tools: Blender's own, and in 4.2 pointers into the void.
    *("particle_edit", "paint_mode", "image_paint", "sculpt", "vertex_paint", "weight_paint", "uv_sculpt"),
    *("gpencil_paint", "gpencil_vertex_paint", "gpencil_sculpt_paint", "gpencil_weight_paint"),
    *("curves_sculpt", "gpencil_sculpt", "gpencil_interpolate"),
}
# Long lists of numbers: (type, collection) -> what of each element counts.
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
    """Every value of every data-block by its path, and the mode, selection and scene of the context."""
    told: dict[str, object] = {}
    for layer in (layer for scene in bpy.data.scenes for layer in scene.view_layers):
        layer.update()
    for kind in _kinds():
        for block in getattr(bpy.data, kind):
            if kind == "libraries" and block.name.startswith(OWN_LIBRARIES):
                continue
            path = f"{kind}/{block.name_full}"
            told[path] = kind
            _properties(told, path, block, set())
            told[f"{path}[custom]"] = _custom(block)
    told["context.mode"] = bpy.context.mode
    told["context.scene"] = bpy.context.scene.name
    for scene in bpy.data.scenes:
        for layer in scene.view_layers:
            active = layer.objects.active
            place = f"{scene.name}/{layer.name}"
            told[f"{place}.active"] = active and active.name
            for thing in layer.objects:
                told[f"{place}.shown/{thing.name}"] = (
                    thing.select_get(view_layer=layer),
                    thing.hide_get(view_layer=layer),
                    thing.mode,
                )
    return told


def differences(
    before: dict[str, object], after: dict[str, object], allowed: Iterable[str] = (), additions: bool = True
) -> list[str]:
    """What of the earlier data is other now, a line each; what is new counts only without ``additions``.

    allowed: patterns of the paths that may change.
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
    """The data-blocks that nobody uses, by kind and name."""
    return {
        f"{kind}/{block.name_full}"
        for kind in _kinds()
        for block in getattr(bpy.data, kind)
        if block.users == 0 and kind != "libraries"
    }


def _kinds() -> list[str]:
    """The names of bpy.data's collections that hold what an artist makes."""
    found = [p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION"]
    return [kind for kind in found if kind not in NOT_THE_ARTISTS]


_MEMBERS: dict[str, list[tuple[str, str]]] = {}


def _members(struct: bpy.types.bpy_struct) -> list[tuple[str, str]]:
    """(name, type) of what a type of Blender's holds of its own."""
    kind = struct.bl_rna.identifier
    if kind not in _MEMBERS:
        properties = struct.bl_rna.properties
        _MEMBERS[kind] = [(p.identifier, p.type) for p in properties if p.identifier not in DERIVED]
    return _MEMBERS[kind]


def _properties(told: dict, path: str, struct: bpy.types.bpy_struct, seen: set) -> None:
    me = struct.as_pointer(), struct.bl_rna.identifier
    if me in seen:  # bones know their parents and these know them
        told[path] = getattr(struct, "name", "seen")
        return
    seen.add(me)
    kind = me[1]
    for name, sort in _members(struct):
        try:
            value = getattr(struct, name)
        except (AttributeError, RuntimeError, ValueError):
            continue  # not to be asked in this state
        where = f"{path}.{name}"
        if sort == "POINTER":
            _pointer(told, where, value, seen)
        elif sort == "COLLECTION":
            _collection(told, where, (kind, name), value, seen)
        else:
            told[where] = _plain(value)


def _pointer(told: dict, path: str, value: object, seen: set) -> None:
    if value is None:
        told[path] = None
    elif isinstance(value, bpy.types.ID) and not value.is_embedded_data:
        told[path] = value.name_full
    else:
        _properties(told, path, value, seen)


def _collection(told: dict, path: str, kind: tuple[str, str], values: object, seen: set) -> None:
    if kind in BULK:
        name, sort, width = BULK[kind]
        numbers = np.empty(len(values) * width, dtype=sort)
        values.foreach_get(name, numbers)
        told[path] = len(values), hashlib.sha1(numbers.tobytes()).hexdigest()[:12]
        return
    told[f"{path}.length"] = len(values)
    for number, value in enumerate(values):
        where = f"{path}[{getattr(value, 'name', number)!s}]"
        if isinstance(value, bpy.types.ID):
            told[where] = value.name_full
        else:
            _properties(told, where, value, seen)
            if hasattr(value, "keys") and isinstance(value, bpy.types.PoseBone):
                told[f"{where}[custom]"] = _custom(value)


def _plain(value: object) -> object:
    """A value that outlives the data-block; not-a-number equals itself."""
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
    """Custom properties as text."""
    told = {}
    for key in sorted(block.keys()):
        if key in block.bl_rna.properties:
            continue  # before Blender 5 an add-on's registered properties are stored here, and are read as such
        value = block[key]
        reader = getattr(value, "to_dict", None) or getattr(value, "to_list", None)
        told[key] = reader() if reader else getattr(value, "name_full", value)
    return repr(told)
