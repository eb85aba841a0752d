"""500 random steps of operators, undo and redo: no traceback, nothing lost, nothing left over, each undo exact."""

from __future__ import annotations

import bpy
import pytest
import random_use
import samp_blender

SEEDS, LENGTH = range(20), 25


@pytest.fixture(scope="module", autouse=True)
def _registered():
    samp_blender.register()
    yield
    samp_blender.unregister()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


@pytest.mark.parametrize("seed", SEEDS)
def test_whatever_is_pressed_nothing_is_lost(seed, tmp_path, monkeypatch):
    random_use.stand_in_for_the_networks(monkeypatch)
    steps, user = random_use.sequence(seed, LENGTH, tmp_path), random_use.User()
    for count, step in enumerate(steps, start=1):
        try:
            user.do(step)
        except Exception as error:
            done = "\n".join(f"  {name} {told}" for name, told in steps[:count])
            raise AssertionError(f"seed {seed}, step {count}: {error}\n{done}") from error
