"""The render farm in the add-on's preferences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

if TYPE_CHECKING:
    from ...batch.farm.sending.engines import Engine

DEADLINE = (
    "deadline bundle submit --yes {bundle}"  # as in batch/farm/sending/engines.py, not imported at redraws
)
KINDS = (
    ("NONE", "Write Only", "Write the folder and submit nothing"),
    ("OPENJD", "Open Job Description", "Submit the folder as a job bundle, such as to AWS Deadline Cloud"),
    ("FLAMENCO", "Flamenco", "Submit to Flamenco's manager"),
    ("DASK", "Dask", "Bake on the workers of a Dask cluster"),
    ("COMMAND", "Own Command", "Run a command line of your own"),
)
HELP = "{bundle} {jobs} {output} {scene} {lines} {chunk} {name}"
FIELDS = {
    "OPENJD": ("farm_openjd", "farm_blender", "farm_script", "farm_chunk"),
    "FLAMENCO": ("farm_manager", "farm_script", "farm_chunk"),
    "DASK": ("farm_scheduler", "farm_python", "farm_chunk"),
    "COMMAND": ("farm_command", "farm_chunk"),
}


def annotations() -> dict[str, object]:
    """Return the properties of the preferences."""
    return {
        "farm_engine": EnumProperty(name="Engine", description="Where Send to Farm submits to", items=KINDS),
        "farm_openjd": StringProperty(
            name="Command", description=f"Command that submits the folder; it knows {HELP}", default=DEADLINE
        ),
        "farm_command": StringProperty(
            name="Command", description=f"Command line that submits the folder; it knows {HELP}"
        ),
        "farm_manager": StringProperty(
            name="Manager", description="Address of Flamenco's manager", default="http://localhost:8080"
        ),
        "farm_scheduler": StringProperty(
            name="Scheduler", description="Address or file of Dask's scheduler, or local:N for N workers here"
        ),
        "farm_python": StringProperty(
            name="Python",
            description="Python of an environment with samp_blender and distributed",
            subtype="FILE_PATH",
        ),
        "farm_blender": StringProperty(
            name="Blender", description="Blender on the workers, or a Python with bpy", default="blender"
        ),
        "farm_script": StringProperty(
            name="Bake Script",
            description="The file bake.py on the workers; if empty, that of this add-on (Flamenco: {samp_bake})",
        ),
        "farm_chunk": IntProperty(
            name="Lines per Task", description="Lines for each task", default=25, min=1
        ),
    }


def draw(layout: bpy.types.UILayout, preferences: bpy.types.AddonPreferences) -> None:
    """Draw the farm's preferences."""
    column = layout.column()
    column.label(text="Render Farm", icon="NETWORK_DRIVE")
    column.prop(preferences, "farm_engine")
    for name in FIELDS.get(preferences.farm_engine, ()):
        column.prop(preferences, name)
    if preferences.farm_engine in ("OPENJD", "COMMAND"):
        column.label(text=f"Replaced in the command: {HELP}")


def chosen(preferences: bpy.types.AddonPreferences | None, kind: str = "") -> Engine:
    """Return the engine that is set, or that of another kind with what is set for it.

    preferences: None where the program runs without having been installed as an add-on.
    """
    from ...batch.farm.sending.bundle import Workers
    from ...batch.farm.sending.engines import Engine

    if preferences is None:
        return Engine(kind or "NONE")
    kind = kind or preferences.farm_engine
    own = {name: getattr(preferences, f"farm_{name}") for name in ("manager", "scheduler")}
    command = preferences.farm_openjd if kind == "OPENJD" else preferences.farm_command
    workers = Workers(preferences.farm_blender, preferences.farm_script, preferences.farm_chunk)
    python = bpy.path.abspath(preferences.farm_python)
    return Engine(kind, command, **own, python=python, workers=workers)
