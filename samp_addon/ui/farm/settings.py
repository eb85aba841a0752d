"""What is sent to a farm, saved with the scene (``scene.samp.farm``)."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

WHAT = (
    ("TAKES", "Takes", "The takes that the generate button would make"),
    ("STEPS", "Steps", "The steps in a row, as one take"),
    ("CAST", "Cast", "All characters of the cast at the same time"),
)


class SAMP_PG_farm(bpy.types.PropertyGroup):
    """Settings of Send to Farm."""

    what: EnumProperty(name="Jobs", description="Which part of the sidebar is sent", items=WHAT)
    folder: StringProperty(
        name="Folder",
        description="Folder for what is sent; the workers must see it under the same name",
        subtype="DIR_PATH",
        default="//farm",
    )
    takes: IntProperty(
        name="Takes",
        description="Number of takes of each job, with seeds upward",
        default=32,
        min=1,
        max=100_000,
    )
    per_line: IntProperty(
        name="Takes per Line",
        description="Number of takes that a worker makes together; more is faster, fewer is spread wider",
        default=8,
        min=1,
        max=1000,
    )
    each_selected: BoolProperty(
        name="Each Selected Object",
        description="Make takes for each selected piece of furniture, rather than for the target alone",
    )
    blends: BoolProperty(
        name="Save .blend Files",
        description="Also save the scene with the takes as Actions, a file for each line",
    )
    previews: BoolProperty(
        name="Previews", description="Also render a small picture of each take for the page of results"
    )
