"""Materials of the default human, one for each part of the body, in eight looks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy

from ...body.human import MATERIALS
from .. import compat

LOOK_KEY = "samp_look"
"""Custom property of a human's armature: the name of its look."""


@dataclass(frozen=True)
class Surface:
    """Linear colour (r, g, b), roughness, and values of other inputs of the Principled BSDF."""

    colour: tuple[float, float, float]
    roughness: float
    inputs: dict[str, float]


SURFACES = {
    "skin": Surface((0.58, 0.33, 0.23), 0.48, {"Subsurface Weight": 0.12, "Subsurface Scale": 0.02}),
    "clothes": Surface((0.045, 0.115, 0.22), 0.85, {"Sheen Weight": 0.35, "Specular IOR Level": 0.2}),
    "trousers": Surface((0.11, 0.10, 0.095), 0.9, {"Sheen Weight": 0.2, "Specular IOR Level": 0.2}),
    "shoes": Surface((0.02, 0.018, 0.016), 0.4, {}),
    "hair": Surface((0.028, 0.016, 0.01), 0.55, {"Sheen Weight": 0.1}),
    "eyes": Surface((0.8, 0.78, 0.75), 0.1, {"Coat Weight": 1.0}),
    "pupils": Surface((0.012, 0.008, 0.006), 0.05, {"Coat Weight": 1.0}),
}

LOOKS: dict[str, dict[str, tuple[float, float, float]]] = {
    "Blue": {},
    "Rust": {"skin": (0.35, 0.17, 0.10), "clothes": (0.30, 0.07, 0.03), "trousers": (0.03, 0.04, 0.07),
             "shoes": (0.10, 0.05, 0.025), "hair": (0.008, 0.006, 0.005)},
    "Moss": {"skin": (0.70, 0.45, 0.34), "clothes": (0.08, 0.12, 0.04), "trousers": (0.20, 0.16, 0.11),
             "shoes": (0.12, 0.07, 0.04), "hair": (0.16, 0.08, 0.03)},
    "Grey": {"skin": (0.62, 0.40, 0.31), "clothes": (0.16, 0.16, 0.17), "trousers": (0.02, 0.02, 0.025),
             "hair": (0.35, 0.34, 0.33)},
    "Plum": {"skin": (0.20, 0.09, 0.05), "clothes": (0.14, 0.03, 0.10), "trousers": (0.06, 0.06, 0.06),
             "shoes": (0.25, 0.23, 0.21), "hair": (0.006, 0.005, 0.005)},
    "Sand": {"skin": (0.50, 0.28, 0.18), "clothes": (0.45, 0.36, 0.24), "trousers": (0.035, 0.06, 0.11),
             "shoes": (0.35, 0.33, 0.31)},
    "Teal": {"skin": (0.74, 0.52, 0.42), "clothes": (0.02, 0.16, 0.16), "trousers": (0.13, 0.12, 0.11),
             "hair": (0.33, 0.20, 0.08)},
    "White": {"skin": (0.42, 0.22, 0.14), "clothes": (0.62, 0.61, 0.58), "trousers": (0.05, 0.07, 0.05),
              "shoes": (0.05, 0.02, 0.015), "hair": (0.012, 0.008, 0.006)},
}  # fmt: skip
"""Linear colours of parts by look; parts that are not named have those of SURFACES."""


def next_look() -> str:
    """Return the look that the fewest humans of the file have, the first of several."""
    worn = [obj.get(LOOK_KEY) for obj in bpy.data.objects if LOOK_KEY in obj]
    return min(LOOKS, key=worn.count)


def body_materials(look: str = next(iter(LOOKS))) -> list[bpy.types.Material]:
    """Return the materials of a look in the order of MATERIALS; existing ones are reused, with the artist's changes."""
    return [_material(part, look) for part in MATERIALS]


def _material(part: str, look: str) -> bpy.types.Material:
    surface, own = SURFACES[part], LOOKS[look].get(part)
    name = f"Human {part}" if own is None else f"Human {part} {look}"
    known = bpy.data.materials.get(name)
    if known is not None and known.library is None:
        return known
    surface = surface if own is None else replace(surface, colour=own)
    material = compat.new_node_material(name)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*surface.colour, 1.0)
    shader.inputs["Roughness"].default_value = surface.roughness
    for key, value in surface.inputs.items():
        shader.inputs[key].default_value = value
    material.diffuse_color = (*surface.colour, 1.0)  # for Workbench and the solid viewport
    material.roughness = surface.roughness
    return material
