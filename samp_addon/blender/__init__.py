"""The artist's scene, character and Actions; besides operators/ and ui/ the only room that imports bpy.

Scripts outside of the repository import some modules by the names below; nothing in the repository does.
"""

import importlib

PUBLISHED = {
    "armature": "character.armature",
    "contact_sheet": "render.contact_sheet",
    "measuring": "takes.measure",
    "read_scene": "scene.read_scene",
    "rig_carrying": "rigs.carry_to_rig",
    "rig_table": "rigs.bone_table",
}


def __getattr__(name: str) -> object:
    if name in PUBLISHED:
        return importlib.import_module(f".{PUBLISHED[name]}", __package__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
