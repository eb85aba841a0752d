"""Units and axes of a scene are checked by the size and the shape of what is in it."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon.blender.scene import preconditions
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.tests.support import layouts

SOFA = layouts.sofa()
ROOM = np.concatenate([layouts.floor(6, 6), SOFA])


def view(scale=1.0, turned=False):
    turn = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]) if turned else np.eye(3)
    scene = SceneGeometry.from_objects([("Room", ROOM * scale @ turn)])
    return SceneView(scene, target=SOFA * scale @ turn)


@pytest.mark.parametrize(
    ("seen", "words"),
    [(view(), ""), (view(100.0), "centimetres.*--units cm"), (view(1000.0), "millimetres.*--units mm"),
     (view(turned=True), "on its side.*--up Z")],
    ids=["metres", "centimetres", "millimetres", "Z up"],
)  # fmt: skip
def test_units_and_axes_of_imported_scenes(seen, words):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if not words:
        preconditions.check(bpy.context, None, [seen])
        return
    with pytest.raises(SampError, match=words):
        preconditions.check(bpy.context, None, [seen])
    bpy.context.scene[preconditions.CONVERTED_KEY] = "m"
    if "side" in words:
        preconditions.check(bpy.context, None, [seen])
