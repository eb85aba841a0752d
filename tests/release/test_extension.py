"""The installed zip: its content, its operation, and the duration of registration."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILDER = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text())

INSTALL_AND_WORK = """
import json, sys, time
import bpy
zip_path, npz_path = sys.argv[1:3]
bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
module = sys.modules["bl_ext.user_default.samp"]
facts = {"torch": "torch" in sys.modules, "file": module.__file__}
facts["operators"] = sorted(name for name in dir(bpy.ops.samp))
facts["polls"] = {name: getattr(bpy.ops.samp, name).poll() for name in facts["operators"]}
facts["create"] = list(bpy.ops.samp.create_character("EXEC_DEFAULT", name="Anna"))
from bl_ext.user_default.samp.samp_addon import motion, rotation
from bl_ext.user_default.samp.samp_addon.body import amass
import numpy as np
still = np.tile([1.0, 0, 0, 0], (8, 22, 1))
amass.write_amass(motion.Motion(np.tile([1.0, 0.9, 2.0], (8, 1)), still), npz_path)
facts["bake"] = list(bpy.ops.samp.bake("EXEC_DEFAULT", filepath=npz_path))
facts["action"] = bpy.data.objects["Anna"].animation_data.action.name
facts["export"] = list(bpy.ops.samp.export_npz("EXEC_DEFAULT", filepath=npz_path.replace(".npz", "_out.npz")))
facts["torch_after"] = "torch" in sys.modules
bpy.ops.preferences.addon_disable(module="bl_ext.user_default.samp")
facts["left"] = [name for name in dir(bpy.types) if name.startswith("SAMP_")]
bpy.ops.preferences.addon_enable(module="bl_ext.user_default.samp")
facts["again"] = bpy.ops.samp.create_character.poll()
# Older Blenders crash at exit when a registered callback is still alive.
bpy.ops.preferences.addon_disable(module="bl_ext.user_default.samp")
print("FACTS" + json.dumps(facts))
"""

REGISTER = """
import json, sys
import bpy
import samp_blender
samp_blender.register()
heavy = [name for name in ("torch", "scipy", "safetensors") if name in sys.modules]
samp_blender.unregister()
print("FACTS" + json.dumps({"heavy": heavy}))
"""


def run(script: str, *arguments: str, **environment: str) -> dict:
    """Run a script in a separate process; return the facts that it prints."""
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("FACTS")]
    assert done.returncode == 0 and lines, done.stdout + done.stderr
    return json.loads(lines[0].removeprefix("FACTS"))


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """Build the zip from the working tree."""
    folder = tmp_path_factory.mktemp("package")
    command = [sys.executable, str(BUILDER), "build", "--source-dir", str(ROOT), "--output-dir", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return next(folder.glob("*.zip"))


def test_manifest_and_zip_are_valid(package):
    for path in (ROOT, package):
        subprocess.run([sys.executable, str(BUILDER), "validate", str(path)], check=True, capture_output=True)
    assert MANIFEST["id"] == "samp" and MANIFEST["blender_version_min"] == "4.2.0"
    assert MANIFEST["license"] == ["SPDX:GPL-3.0-or-later"]
    assert all(reason.strip() for reason in MANIFEST["permissions"].values())


def test_code_and_manifest_agree_on_the_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == MANIFEST["version"] and project["license"]["text"] == "GPL-3.0-or-later"


def test_only_runtime_files_are_shipped(package):
    with zipfile.ZipFile(package) as archive:
        names = archive.namelist()
    tops = {name.split("/")[0] for name in names}
    assert {"__init__.py", "blender_manifest.toml", "operators", "samp_addon", "models"} <= tops
    assert {"LICENSE", "THIRD_PARTY.md"} <= tops
    assert not tops & {
        "training",
        "tests",
        "docs",
        "release",
        "demo",
        "dist",
        "Makefile",
        ".git",
        ".venv",
        ".ci",
        "cache",
    }
    assert "samp_addon/body/human.npz" in names
    assert not [name for name in names if name.endswith((".pyc", ".bvh", ".c3d", ".amc"))]


def test_installs_and_works(package, tmp_path):
    facts = run(
        INSTALL_AND_WORK,
        str(package),
        str(tmp_path / "wave.npz"),
        BLENDER_USER_RESOURCES=str(tmp_path / "blender"),
    )
    assert str(tmp_path) in facts["file"]
    assert {"create_character", "bake", "export_npz"} <= set(facts["operators"])
    assert facts["polls"]["create_character"] is True and facts["polls"]["bake"] is False
    assert facts["create"] == facts["bake"] == facts["export"] == ["FINISHED"]
    assert facts["action"] == "wave" and (tmp_path / "wave_out.npz").exists()
    assert not facts["torch"] and not facts["torch_after"]
    assert facts["left"] == [] and facts["again"]


def test_registers_without_heavy_packages():
    assert run(REGISTER)["heavy"] == []
