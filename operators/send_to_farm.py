"""Send to Farm: the sidebar's jobs as a folder with a copy of the scene, submitted to the engine of the preferences."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.props import StringProperty

from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.batch.farm.sending.engines import Engine
    from ..samp_addon.batch.farm.sending.sending import Sending
    from ..samp_addon.blender.thread_run import ThreadRun


class SAMP_OT_send_to_farm(ThreadOperator, bpy.types.Operator):
    """Write the jobs and a copy of the scene to a folder, and submit them to the farm of the preferences"""

    bl_idname = "samp.send_to_farm"
    bl_label = "Send to Farm"

    folder: StringProperty(
        name="Folder",
        description="Folder to write; if empty, a new one in the sidebar's",
        options={"SKIP_SAVE"},
    )
    engine: StringProperty(
        name="Engine",
        description="NONE, OPENJD, FLAMENCO, DASK or COMMAND; if empty, that of the preferences",
        options={"SKIP_SAVE"},
    )
    address: StringProperty(
        name="Address", description="Of Flamenco's manager or Dask's scheduler", options={"SKIP_SAVE"}
    )
    command: StringProperty(name="Command", description="Command line that submits", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        from ..samp_addon.ui.farm import jobs

        if not super().poll(context):
            return False
        reason = jobs.why_not(context)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def run_now(self, context: bpy.types.Context) -> str:
        return self._prepared(context).finish(lambda stage, share: None)

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender import thread_run

        sending = self._prepared(context)
        return thread_run.ThreadRun(
            sending.finish, lambda context, sentence: thread_run.one_slice(lambda: sentence)
        )

    def finished(self, result: str) -> str:
        settings = bpy.context.scene.samp
        settings.seed = (settings.seed + settings.farm.takes) % 2**31  # the next press sends other takes
        return result

    def _prepared(self, context: bpy.types.Context) -> Sending:
        """Return what is left to do without Blender, once the copy of the scene is saved. Raise SampError."""
        from ..samp_addon.batch.farm.sending import engines, sending
        from ..samp_addon.blender.scene import libraries, open_scene
        from ..samp_addon.ui.farm import jobs

        engine = self._engine(context)
        engines.check(engine, bpy.app.online_access)
        settings = context.scene.samp.farm
        name = Path(bpy.data.filepath).stem or "untitled"
        files = {"blends": settings.blends, "previews": settings.previews}
        texts = sending.texts(jobs.of_settings(context), settings.takes, settings.per_line, **files)
        folder = self._folder(name)
        open_scene.save_copy(folder / sending.SCENE, "choose another folder")
        home = Path(bpy.data.filepath).parent if bpy.data.filepath else folder
        return sending.Sending(folder, name, texts, engine, home, tuple(libraries.linked()))

    def _folder(self, name: str) -> Path:
        """Return the folder to write. Raise SampError where there is none, or it holds jobs already."""
        from ..samp_addon.errors import SampError

        given = self.folder or bpy.context.scene.samp.farm.folder
        if given.startswith("//") and not bpy.data.filepath:
            raise SampError("The file was never saved; save it, or choose a folder for the farm.")
        if not given:
            raise SampError("No folder was named; choose a folder for the farm.")
        folder = Path(bpy.path.abspath(given)).absolute()
        if not self.folder:
            folder /= f"{name}_{time.strftime('%Y%m%d_%H%M%S')}"
        if folder.exists() and any(folder.iterdir()):
            raise SampError(f"'{folder}' is not empty; choose another folder.")
        return folder

    def _engine(self, context: bpy.types.Context) -> Engine:
        """Return the engine of the preferences, and of it what the caller has not set."""
        from ..samp_addon.ui import preferences
        from ..samp_addon.ui.farm import engine

        addon = context.preferences.addons.get(preferences.SAMP_AP_preferences.bl_idname)
        found = engine.chosen(None if addon is None else addon.preferences)
        own = {
            "kind": self.engine,
            "command": self.command,
            "manager": self.address,
            "scheduler": self.address,
        }
        return replace(found, **{name: value for name, value in own.items() if value})
