"""The zips with wheels: their content, skipped platforms, and operation without other packages."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy
import pytest
import rooms
from samp_blender.release import build, wheels
from samp_blender.samp_addon import dependencies

ROOT = Path(__file__).resolve().parents[2]
CACHED = ROOT / "cache" / "wheels"
MANIFEST = (ROOT / "blender_manifest.toml").read_text()
# Packages of this Python that Blender ships as well; a process with only these simulates Blender.
SHIPPED = (
    "bpy",
    "numpy",
    "numpy.libs",
    "requests",
    "urllib3",
    "certifi",
    "idna",
    "charset_normalizer",
    "zstandard",
)

SIT = """
import importlib, json, sys, time
import bpy
zip_path, room, folder = sys.argv[1:4]
facts, begun = {}, time.perf_counter()
bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
facts["install"] = time.perf_counter() - begun
preferences = importlib.import_module("bl_ext.user_default.samp.samp_addon.ui.preferences")
facts["missing"] = [package.module for package in preferences.dependencies.missing()]
facts["advice"] = preferences.advice(preferences.dependencies.missing())
facts["commands"] = preferences.install_commands()
facts["loaded"] = [name for name in ("torch", "scipy", "safetensors") if name in sys.modules]
bpy.ops.wm.open_mainfile(filepath=room)
ways = {
    "create_character": {}, "bake": {"filepath": folder + "/in.npz"}, "export_npz": {"filepath": folder + "/out.npz"},
    "voxelise": {"target": "Sofa"}, "build_navmesh": {}, "plan_path": {"target": "Sofa"}, "measure": {},
    "sit_here": {"target": "Sofa"}, "sample_goals": {"target": "Sofa"}, "refine": {},
}
for name, options in ways.items():
    try:
        facts[name] = list(getattr(bpy.ops.samp, name)("EXEC_DEFAULT", **options))
    except RuntimeError as error:
        facts[name] = str(error)
facts["from"] = {name: sys.modules[name].__file__ for name in ("torch", "scipy", "safetensors") if name in sys.modules}
bpy.ops.preferences.addon_disable(module="bl_ext.user_default.samp")
print("FACTS" + json.dumps(facts))
"""


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Build the zip without wheels that the others are based on."""
    path = tmp_path_factory.mktemp("plain") / "plain.zip"
    build._blender("build", "--source-dir", str(ROOT), "--output-filepath", str(path))
    return path


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    path = tmp_path_factory.mktemp("room") / "room.blend"
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


@pytest.fixture
def install(room, tmp_path):
    """Return a function that installs a zip next to Blender's packages only and reports the results of operators."""
    from samp_blender.samp_addon import motion, rotation
    from samp_blender.samp_addon.body import amass

    still = rotation.about_y([0.0] * 8)[:, None].repeat(22, axis=1)
    amass.write_amass(motion.Motion(still[:, 0, :3] * 0, still), tmp_path / "in.npz")
    (tmp_path / "site").mkdir()
    folders = [Path(place) for place in sys.path if place.endswith("site-packages")]
    for name in SHIPPED:
        places = [folder / name for folder in folders if (folder / name).is_dir()]
        if places:
            (tmp_path / "site" / name).symlink_to(places[0])

    def press(zip_path):
        environment = os.environ | {
            "BLENDER_USER_RESOURCES": str(tmp_path / "user"),
            "PYTHONPATH": str(tmp_path / "site"),
        }
        # -S: without the packages of this Python.
        command = [sys.executable, "-S", "-c", SIT, str(zip_path), str(room), str(tmp_path)]
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=500, check=False
        )
        lines = [line for line in done.stdout.splitlines() if line.startswith("FACTS")]
        assert done.returncode == 0 and lines, done.stdout + done.stderr
        return json.loads(lines[0].removeprefix("FACTS"))

    return press


def cached(*names):
    """Return wheels of this platform from an earlier `make package`; skip the test if there are none."""
    found = []
    for name in names:
        found += sorted((CACHED / "linux-x64" / "3.11" / name).glob("*.whl"))[:1]
    if sys.platform != "linux" or len(found) < len(names):
        pytest.skip("There are no wheels in cache/wheels; run `make package` first.")
    return found


NETWORKLESS = (
    "create_character",
    "bake",
    "export_npz",
    "voxelise",
    "build_navmesh",
    "plan_path",
    "measure",
)


def test_with_all_wheels_everything_works(plain, install, tmp_path):
    path = build._build(plain, tmp_path, "", "linux-x64", cached(*wheels.LISTED["versions"]))
    facts = install(path)
    assert facts["missing"] == facts["advice"] == facts["loaded"] == []
    assert {
        name: facts[name] for name in (*NETWORKLESS, "sit_here", "sample_goals", "refine")
    } == dict.fromkeys((*NETWORKLESS, "sit_here", "sample_goals", "refine"), ["FINISHED"])
    assert all(str(tmp_path / "user") in place for place in facts["from"].values())
    assert set(facts["from"]) == {"torch", "scipy", "safetensors"}


def test_without_torch_the_operators_without_networks_work(plain, install, tmp_path):
    names = [name for name in wheels.LISTED["versions"] if name not in wheels.TORCH]
    facts = install(build._build(plain, tmp_path, "light", "linux-x64", cached(*names)))
    assert facts["missing"] == ["torch"] and facts["loaded"] == []
    assert {name: facts[name] for name in NETWORKLESS} == dict.fromkeys(NETWORKLESS, ["FINISHED"])
    for name in ("sit_here", "sample_goals", "refine"):
        assert facts[name].count("\n") == 1 and "'torch' is missing; Edit > Preferences" in facts[name]
    assert "torch" in facts["commands"] and "scripts/modules" in facts["commands"]
    assert any("zip" in line for line in facts["advice"])


def test_without_wheels_each_operator_names_the_missing_package(plain, install, tmp_path):
    facts = install(build._build(plain, tmp_path, "bare"))
    assert facts["missing"] == [package.module for package in dependencies.PACKAGES]
    assert [name for name in NETWORKLESS if facts[name] == ["FINISHED"]] == [
        "create_character",
        "bake",
        "export_npz",
    ]
    for name in ("voxelise", "build_navmesh", "plan_path", "measure", "sit_here", "sample_goals", "refine"):
        assert facts[name].count("\n") == 1 and "'scipy' is missing; Edit > Preferences" in facts[name]


def fake_wheel(folder, name):
    path = folder / name
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("scipy/__init__.py", "")
    return path


def test_a_zip_contains_and_lists_its_wheels(plain, tmp_path):
    names = ("scipy-1.15.3-cp311-cp311-win_amd64.whl", "packaging-26.3-py3-none-any.whl")
    path = build._build(
        plain, tmp_path, "light", "windows-x64", [fake_wheel(plain.parent, name) for name in names]
    )
    assert path.name == f"samp-light-{tomllib.loads(MANIFEST)['version']}-windows_x64.zip"
    with zipfile.ZipFile(path) as archive:
        inside = set(archive.namelist())
        facts = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert {f"wheels/{name}" for name in names} <= inside
    assert facts["wheels"] == [f"./wheels/{name}" for name in names]
    assert facts["platforms"] == ["windows-x64"] and facts["id"] == "samp"
    assert facts["permissions"] == tomllib.loads(MANIFEST)["permissions"]
    assert {"LICENSE", "THIRD_PARTY.md", "models/weights/furniture_credits.csv"} <= inside
    assert not [name for name in inside if name.startswith(("release/", "tests/", "docs/"))]


def test_a_python_version_is_supported_with_all_wheels_or_not_at_all(monkeypatch, tmp_path):
    def get(name, platform, python, folder):
        if (name, python) == ("torch", "3.13"):
            return None, "no wheel of torch"
        tag = "py3" if name == "packaging" else python
        return tmp_path / f"{name}-{tag}.whl", ""

    monkeypatch.setattr(wheels, "_get", get)
    got = wheels.collect("linux-x64", tmp_path)
    assert got.left_out == {"3.13": "no wheel of torch"} and got.pythons == ["3.11", "3.14"]
    assert [path.name for path in got.wheels].count("packaging-py3.whl") == 1
    assert not [path for path in got.wheels if "3.13" in path.name]
    light = wheels.collect("linux-x64", tmp_path, excluded=wheels.TORCH)
    assert light.pythons == list(wheels.PYTHONS) and not [p for p in light.wheels if "torch" in p.name]


@pytest.mark.parametrize(("python", "version"), [("3.11", "1.15.3"), ("3.13", "1.15.3"), ("3.14", "1.16.3")])
def test_a_python_version_may_need_another_version_of_a_package(python, version):
    assert wheels.requirement("scipy", "linux-x64", python) == f"scipy=={version}"
    assert wheels.requirement("torch", "linux-x64", python).endswith("+cpu")
    assert not wheels.requirement("torch", "windows-x64", python).endswith("+cpu")


def test_a_platform_without_wheels_is_skipped_with_the_reason(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(wheels, "_get", lambda *what: (None, "no wheel of it"))
    assert build.main(["--kinds", "full", "--platforms", "macos-arm64", "--output", str(tmp_path)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) == len(wheels.PYTHONS) and not list(tmp_path.iterdir())
    assert all(line.startswith("left out: full macos-arm64 for Blender") for line in said)
    assert all(line.endswith("no wheel of it") for line in said)


def test_a_wheel_that_does_not_exist(monkeypatch, tmp_path):
    monkeypatch.setitem(wheels.LISTED["versions"], "scipy", "0.0.1")
    for variable, value in (("PIP_NO_INDEX", "1"), ("PIP_CONFIG_FILE", os.devnull), ("PIP_FIND_LINKS", "")):
        monkeypatch.setenv(variable, value)
    wheel, reason = wheels._get("scipy", "linux-x64", "3.11", tmp_path)
    assert wheel is None
    assert re.match(r"no wheel of scipy==0.0.1 for Python 3.11 \(No matching distribution", reason)


def test_lists_of_packages_agree():
    assert {package.module for package in dependencies.PACKAGES} == set(wheels.LISTED["versions"])
    pinned = dict(line.split("==") for line in (ROOT / "requirements.txt").read_text().split())
    for name, version in wheels.LISTED["versions"].items():
        assert pinned.get(name, version) == version
        assert name in (ROOT / "THIRD_PARTY.md").read_text()
