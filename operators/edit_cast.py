"""Edit Cast: add, remove and move the characters of the cast."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty


class SAMP_OT_edit_cast(bpy.types.Operator):
    """Add, remove or move a character of the cast"""

    bl_idname = "samp.edit_cast"
    bl_label = "Edit Cast"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    change: EnumProperty(
        name="Change",
        description="How to change the cast",
        items=(
            ("ADD", "Add", "Add the selected characters, or a new human, with the current action and target"),
            ("REMOVE", "Remove", "Remove the active character from the cast"),
            ("UP", "Up", "Move the active character up; earlier ones set off first"),
            ("DOWN", "Down", "Move the active character down; earlier ones set off first"),
        ),
    )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return cls.bl_rna.properties["change"].enum_items[properties.change].description

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.scene.samp
        cast, at = settings.cast, settings.cast_index
        if self.change == "ADD":
            self._add(context)
            settings.cast_index = len(cast) - 1
        elif not 0 <= at < len(cast):
            self.report({"INFO"}, "No character of the cast is active; click one in the list.")
            return {"CANCELLED"}
        elif self.change == "REMOVE":
            cast.remove(at)
            settings.cast_index = max(0, min(at, len(cast) - 1))
        else:
            to = max(0, min(at + (1 if self.change == "DOWN" else -1), len(cast) - 1))
            cast.move(at, to)
            settings.cast_index = to
        return {"FINISHED"}

    @staticmethod
    def _add(context: bpy.types.Context) -> None:
        """Add the selected characters that are not in the cast, or a new human, each with a piece of the selection."""
        from ..samp_addon.blender.scene import candidates, targets
        from ..samp_addon.ui.cast import jobs

        settings = context.scene.samp
        known = [member.character for member in settings.cast]
        added = [obj for obj in jobs.selected_characters(context) if obj not in known] or [None]
        pieces = list(dict.fromkeys(targets.whole(obj) for obj in candidates.selected(context)))
        pieces = pieces or ([settings.target] if settings.target is not None else [])
        for number, character in enumerate(added):
            member = settings.cast.add()
            member.character, member.action = character, settings.action
            member.target = pieces[number % len(pieces)] if pieces else None
            member.place = context.scene.cursor.location
