"""Materials of the default human, one for each part of the body."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ...body.human import MATERIALS
from .. import compat


@dataclass(frozen=True)
class Look:
    """Linear colour (r, g, b), roughness, and values of other inputs of the Principled BSDF."""

    colour: tuple[float, float, float]
    roughness: float
    inputs: dict[str, float]


LOOKS = {
    "skin": Look((0.58, 0.33, 0.23), 0.48, {"Subsurface Weight": 0.12, "Subsurface Scale": 0.02}),
    "clothes": Look((0.045, 0.115, 0.22), 0.85, {"Sheen Weight": 0.35, "Specular IOR Level": 0.2}),
    "trousers": Look((0.11, 0.10, 0.095), 0.9, {"Sheen Weight": 0.2, "Specular IOR Level": 0.2}),
    "shoes": Look((0.02, 0.018, 0.016), 0.4, {}),
    "hair": Look((0.028, 0.016, 0.01), 0.55, {"Sheen Weight": 0.1}),
    "eyes": Look((0.8, 0.78, 0.75), 0.1, {"Coat Weight": 1.0}),
    "pupils": Look((0.012, 0.008, 0.006), 0.05, {"Coat Weight": 1.0}),
}


def body_materials() -> list[bpy.types.Material]:
    """Return the materials in the order of MATERIALS; existing ones are reused, with the artist's changes."""
    return [_material(part) for part in MATERIALS]


def _material(part: str) -> bpy.types.Material:
    name = f"Human {part}"
    known = bpy.data.materials.get(name)
    if known is not None and known.library is None:
        return known
    look = LOOKS[part]
    material = compat.new_node_material(name)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*look.colour, 1.0)
    shader.inputs["Roughness"].default_value = look.roughness
    for key, value in look.inputs.items():
        shader.inputs[key].default_value = value
    material.diffuse_color = (*look.colour, 1.0)  # for Workbench and the solid viewport
    material.roughness = look.roughness
    return material
