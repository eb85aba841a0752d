"""The installed zip: every operator polls in every mode, runs or reports an error, and undoes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import bpy
import pytest
from samp_blender.operators import OPERATORS

ROOT = Path(__file__).resolve().parents[2]
BUILDER = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"


@pytest.fixture(scope="module")
def facts(tmp_path_factory) -> dict:
    """Output of poll_everywhere.py for the zip, installed in a separate Blender."""
    folder = tmp_path_factory.mktemp("package")
    command = [sys.executable, str(BUILDER), "build", "--source-dir", str(ROOT), "--output-dir", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    script = ROOT / "tests" / "support" / "blender" / "poll_everywhere.py"
    done = subprocess.run(
        [sys.executable, str(script), str(next(folder.glob("*.zip"))), str(folder)],
        env=os.environ | {"BLENDER_USER_RESOURCES": str(folder / "blender")},
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("FACTS")]
    assert done.returncode == 0 and lines, done.stdout + done.stderr
    return json.loads(lines[0].removeprefix("FACTS"))


def test_all_operators_are_there(facts):
    assert set(OPERATORS) <= set(facts["operators"])


def test_every_mode_and_every_kind_of_object_was_tried(facts):
    assert len(facts["places"]) >= 25
    assert {"OBJECT", "POSE", "EDIT_MESH", "SCULPT", "PAINT_WEIGHT", "EDIT_ARMATURE", "EDIT_CURVE"} <= {
        place["mode"] for place in facts["places"].values()
    }


def test_polls_return_bool(facts):
    wrong = {name: place["wrong"] for name, place in facts["places"].items() if place["wrong"]}
    assert wrong == {}


def test_polls_fail_outside_of_object_and_pose_mode(facts):
    """Operators that change keyframes or objects cannot run in other modes."""
    for name, place in facts["places"].items():
        for operator in ("sit_here", "lie_here", "walk_here", "refine", "bake", "create_character"):
            if place["mode"] not in ("OBJECT", "POSE"):
                assert place["polls"][operator] is False, (name, operator)


def test_operators_finish_or_report_one_sentence(facts):
    """Run with defaults wherever the poll allows it."""
    wrong = {
        f"{operator} {place}": message
        for place, answers in facts["pressed"].items()
        for operator, message in answers.items()
        if "Traceback" in message or message.strip().count("\n")
    }
    assert wrong == {}
    assert len(facts["pressed"]) >= 5 and all(facts["pressed"].values())


@pytest.mark.parametrize("operator", OPERATORS)
def test_undo_restores_the_file(facts, operator):
    """One undo restores the file."""
    if operator not in facts["undone"]:
        pytest.skip("it changes nothing in the room of this test, or cannot run there")
    assert facts["undone"][operator] == []
