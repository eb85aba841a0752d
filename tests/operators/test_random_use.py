"""Random sequences of operators, undo and redo: no traceback, no data lost or left over, exact undo.

Set RANDOM_USE=500 for 500 sequences, which takes a quarter of an hour; the default is 12.
"""

from __future__ import annotations

import os

import bpy
import pytest
import random_use
import samp_blender
import untrained
from samp_blender.samp_addon.methods import registry

SEEDS, LENGTH = range(int(os.environ.get("RANDOM_USE", "12"))), 8


SUB_GOALS = (
    "add_sub_goal", "add_sub_goal", "add_sub_goal", "move_sub_goal", "remove_sub_goal", "clear_sub_goals",
    "sample_bodies", "pin_body", "use_current_pose", "clear_overlays",
)  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def _registered():
    samp_blender.register()
    yield
    samp_blender.unregister()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


@pytest.mark.parametrize("seed", SEEDS)
def test_random_sequences_lose_no_data(seed, tmp_path, monkeypatch):
    random_use.replace_networks(monkeypatch)
    _do(seed, random_use.sequence(seed, LENGTH, tmp_path))


@pytest.mark.parametrize("seed", SEEDS[: max(2, len(SEEDS) // 6)])
def test_random_sub_goals_lose_no_data(seed, tmp_path, monkeypatch):
    monkeypatch.setitem(registry.METHODS, "long_term", untrained.method())
    clicks = ("Human", "Sofa", "Sub-goal 1 of Human", "Sub-goal 2 of Human", None)
    _do(seed, random_use.sequence(seed, 2 * LENGTH, tmp_path, SUB_GOALS, clicks))


def _do(seed, steps):
    user = random_use.User()
    for count, step in enumerate(steps, start=1):
        try:
            user.do(step)
        except Exception as error:
            done = "\n".join(f"  {name} {arguments}" for name, arguments in steps[:count])
            raise AssertionError(f"seed {seed}, step {count}: {error}\n{done}") from error
