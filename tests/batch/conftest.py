"""A room for the tests of the batch."""

from __future__ import annotations

import bpy
import pytest
import rooms


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A room as a .blend, and its start."""
    path = tmp_path_factory.mktemp("room") / "room.blend"
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    start = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path, [str(round(v, 4)) for v in start]
