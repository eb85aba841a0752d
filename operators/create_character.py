"""Create Character: the default human at the 3D cursor."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from ..samp_addon.blender.character import materials, measures
from . import outcome

AUTOMATIC = "AUTOMATIC"
LOOKS = [(AUTOMATIC, "Automatic", "Another look than the humans that are there")]
LOOKS += [(look, look, f"{look} clothes") for look in materials.LOOKS]
SHAPES = ("male", "female", "tall", "short", "heavy", "thin", "muscular", "elder")


def _shape(name: str, description: str) -> object:
    return FloatProperty(name=name, description=description, default=0.0, min=0.0, max=1.0, subtype="FACTOR")


class SAMP_OT_create_character(bpy.types.Operator):
    """Create a human on an SMPL-X armature at the 3D cursor"""

    bl_idname = "samp.create_character"
    bl_label = "Create Character"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the new armature", default="Human")
    location: FloatVectorProperty(
        name="Location", description="Location of the soles", subtype="TRANSLATION", size=3
    )
    yaw: FloatProperty(
        name="Facing",
        description="Rotation to the left from facing -Y, seen from above",
        subtype="ANGLE",
        default=0.0,
    )
    male: _shape("Male", "Weight of a male figure")
    female: _shape("Female", "Weight of a female figure")
    tall: _shape("Tall", "Weight of a tall figure")
    short: _shape("Short", "Weight of a short figure")
    heavy: _shape("Heavy", "Weight of a heavy figure")
    thin: _shape("Thin", "Weight of a thin figure")
    muscular: _shape("Muscular", "Weight of a muscular figure")
    elder: _shape("Elder", "Weight of an elderly figure")
    look: EnumProperty(name="Look", description="Colours of skin, hair and clothes", items=LOOKS)
    __annotations__ |= measures.of_operator()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_mode(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.location = context.scene.cursor.location
        return self.execute(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._create(context))

    def _create(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.character import character
        from ..samp_addon.blender.overlays import start_marker

        shapes = character.shapes_for(
            measures.of_properties(self), {name: getattr(self, name) for name in SHAPES}
        )
        made = character.create_character(
            context,
            shapes,
            tuple(self.location),
            self.yaw,
            self.name,
            "" if self.look == AUTOMATIC else self.look,
        )
        start_marker.show(context, made)
        context.scene.samp.character = context.scene.samp.character or made
        return f"Created '{made.name}'."
