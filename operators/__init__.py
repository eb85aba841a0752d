"""The operators, ``bpy.ops.samp.<name>``: one file each, named as the id."""

from __future__ import annotations

import importlib

# All operators; a new one is a file in this folder and its name here. Each imports the program when it runs, not when
# it is registered, so that Blender's start stays fast.
OPERATORS = (
    "create_character",
    "generate",
    "bake_chain",
    "edit_chain",
    "bake_cast",
    "edit_cast",
    "stop",
    "sit_here",
    "lie_here",
    "walk_here",
    "place",
    "draw_path",
    "improvise",
    "voxelise",
    "sample_goals",
    "build_navmesh",
    "plan_path",
    "add_waypoint",
    "set_start",
    "add_sub_goal",
    "remove_sub_goal",
    "move_sub_goal",
    "clear_sub_goals",
    "sample_bodies",
    "pin_body",
    "use_current_pose",
    "clear_overlays",
    "show_take",
    "step_take",
    "star_take",
    "delete_take",
    "push_down_take",
    "retime_take",
    "loop_take",
    "reduce_keys",
    "blend_take",
    "take_to_strip",
    "mark_take",
    "save_asset",
    "redo_from_here",
    "follow_goal",
    "bake",
    "refine",
    "look_at",
    "hand_target",
    "set_cushion",
    "measure",
    "export_npz",
    "export_take",
    "carry_to_rig",
    "guess_rig_map",
    "add_control_rig",
    "remove_control_rig",
    "send_to_farm",
    "copy_install_commands",
    "add_preset",
)


def operator_class(name: str) -> type:
    """Return the class in ``operators/<name>.py`` whose ``bl_idname`` is ``samp.<name>``."""
    module = importlib.import_module(f".{name}", __package__)
    for member in vars(module).values():
        if isinstance(member, type) and getattr(member, "bl_idname", None) == f"samp.{name}":
            return member
    raise LookupError(f"operators/{name}.py defines no operator with bl_idname 'samp.{name}'")


def register() -> None:
    """Register the operators, then the panels that show them."""
    import bpy

    from ..samp_addon import ui
    from ..samp_addon.blender.edits import watching
    from ..samp_addon.blender.overlays import trails
    from ..samp_addon.blender.rigs import bone_table
    from ..samp_addon.blender.sub_goals import following

    bone_table.register()
    for name in OPERATORS:
        bpy.utils.register_class(operator_class(name))
    ui.register()
    following.register()
    watching.register()
    trails.register()


def unregister() -> None:
    """Undo ``register`` in reverse order."""
    import bpy

    from ..samp_addon import ui
    from ..samp_addon.blender.edits import watching
    from ..samp_addon.blender.overlays import trails
    from ..samp_addon.blender.rigs import bone_table
    from ..samp_addon.blender.sub_goals import following

    trails.unregister()
    watching.unregister()
    following.unregister()
    ui.unregister()
    for name in reversed(OPERATORS):
        bpy.utils.unregister_class(operator_class(name))
    bone_table.unregister()
