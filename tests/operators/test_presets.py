"""Presets of the Options panel: those that come with the program, and the artist's own."""

from pathlib import Path

import bpy
import pytest
from samp_blender.samp_addon.ui import presets
from samp_blender.samp_addon.vocabulary import POSTURE_NAMES

SHIPPED = sorted((Path(presets.__file__).parent / presets.FOLDER).glob("*.py"))


pytestmark = pytest.mark.usefixtures("registered")


def test_blender_finds_the_presets():
    assert len(SHIPPED) >= 4
    folders = [Path(folder) for folder in bpy.utils.preset_paths(presets.FOLDER)]
    assert SHIPPED[0].parent in folders


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_preset_is_applied(path):
    settings = bpy.context.scene.samp
    before = {name: getattr(settings, name) for name in presets.SETTINGS}
    assert bpy.ops.script.execute_preset(filepath=str(path), menu_idname="SAMP_PT_presets") == {"FINISHED"}
    after = {name: getattr(settings, name) for name in presets.SETTINGS}
    assert after != before
    assert set(after["samp_posture"]) <= set(POSTURE_NAMES)


def test_an_own_preset_is_written_and_read_back(tmp_path, monkeypatch):
    monkeypatch.setattr(bpy.utils, "user_resource", lambda *_, path="", **__: str(tmp_path / path))
    (tmp_path / "presets" / presets.FOLDER).mkdir(parents=True)
    settings = bpy.context.scene.samp
    settings.speed, settings.samp_posture = 0.7, {"lean_back"}
    assert bpy.ops.samp.add_preset(name="mine") == {"FINISHED"}
    (written,) = tmp_path.rglob("mine.py")
    settings.speed, settings.samp_posture = 1.0, set()
    bpy.ops.script.execute_preset(filepath=str(written), menu_idname="SAMP_PT_presets")
    assert settings.speed == pytest.approx(0.7) and settings.samp_posture == {"lean_back"}
