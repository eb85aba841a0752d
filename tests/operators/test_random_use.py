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


# Edits of finished takes, and what they need: something to follow, another Action, several characters.
EDITS = (
    "follow_goal", "follow_goal", "redo_from_here", "retime_take", "loop_take", "reduce_keys", "blend_take",
    "take_to_strip", "push_down_take", "mark_take", "save_asset", "look_at", "hand_target", "refine", "place",
    "draw_path", "improvise", "bake_cast", "edit_cast", "edit_chain", "bake_chain", "star_take", "show_take",
    "step_take", "delete_take", "add_waypoint", "sample_goals", "set_start", "walk_here", "sit_here",
    "clear_overlays", "add_control_rig", "add_control_rig", "remove_control_rig",
)  # fmt: skip
BEGINNINGS = (
    (("sample_goals", {"target": "Sofa", "count": 1}), ("sit_here", {"target": "Sofa", "hold": 1.0})),
    (("add_waypoint", {}), ("walk_here", {"location": (-0.5, -1.5, 0.0)})),
    (("sit_here", {"target": "Sofa", "hold": 0.0, "variants": 2}), ("star_take", {})),
)


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


@pytest.mark.parametrize("seed", SEEDS)
def test_random_edits_of_takes_lose_no_data(seed, tmp_path, monkeypatch):
    random_use.replace_networks(monkeypatch)
    edits = random_use.sequence(seed, LENGTH, tmp_path, EDITS)
    _do(seed, [("click", {"name": "Human"}), *BEGINNINGS[seed % len(BEGINNINGS)], *edits])


def test_every_edit_of_a_take_is_made_and_undone(tmp_path, monkeypatch):
    """The random edits are no empty ones: on a take that was just made, each of these changes the file."""
    random_use.replace_networks(monkeypatch)
    made = []
    for name, chosen in (
        ("redo_from_here", {"use_frame": True, "frame": 20}),
        ("retime_take", {"walk": 1.4}),
        ("reduce_keys", {}),
        ("mark_take", {"steps": True}),
        ("look_at", {"target": "Sofa"}),
        ("hand_target", {"target": "Sofa"}),
        ("blend_take", {"other": "Mine", "frames": 8}),
        ("take_to_strip", {}),
        ("place", {"location": (0.0, 1.6, 0.43)}),
        ("follow_goal", {}),
    ):
        user = random_use.User()
        for step in (("click", {"name": "Human"}), *BEGINNINGS[0]):
            user.do(step)
        if name == "follow_goal":
            user.do(("drag", {"name": "Goal sit Sofa", "by": (0.3, 0.0, 0.0)}))
        steps = user.now
        user.do((name, chosen))
        if user.now == steps + 1:
            made.append(name)
        for kind in ("undo", "redo"):
            user.do((kind, {}))
    assert len(made) == 10, made


def _do(seed, steps):
    user = random_use.User()
    for count, step in enumerate(steps, start=1):
        try:
            user.do(step)
        except Exception as error:
            done = "\n".join(f"  {name} {arguments}" for name, arguments in steps[:count])
            raise AssertionError(f"seed {seed}, step {count}: {error}\n{done}") from error
