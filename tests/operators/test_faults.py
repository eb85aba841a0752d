"""Faulty files and scenes: success, or one clear sentence that says what to do; the artist's data do not change."""

from __future__ import annotations

import bpy
import fakes
import fault_characters
import fault_files
import fault_moments
import fault_program
import fault_scenes
import fault_targets
import faults
import pytest
import samp_blender
from samp_blender.samp_addon.methods.samp import goals, networks
from samp_blender.samp_addon.refine import refinement as optimiser

PARTS = (fault_scenes, fault_targets, fault_characters, fault_moments, fault_files, fault_program)
CASES = tuple(case for part in PARTS for case in part.CASES)


@pytest.fixture(scope="module", autouse=True)
def _registered():
    samp_blender.register()
    yield
    samp_blender.unregister()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """The room as a file, and the human's location and yaw."""
    path = tmp_path_factory.mktemp("room") / "room.blend"
    return path, faults.build(path)


@pytest.fixture
def room(saved, tmp_path):
    path, start = saved
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    bpy.context.preferences.edit.use_global_undo = True
    return faults.Room(tmp_path, start)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_success_or_clear_message(room, case, monkeypatch):
    if not case.networks:
        monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
        monkeypatch.setattr(goals, "sample_goals", fakes.sample_goals)
        monkeypatch.setattr(optimiser, "refine", fakes.refine)
    case.run(room)


def test_there_are_enough_of_them():
    assert len({case.name for case in CASES}) == len(CASES) >= 60
