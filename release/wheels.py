"""Collect the wheels of a platform with pip, from the package index that pip is configured for."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

LISTED = tomllib.loads((Path(__file__).parent / "wheels.toml").read_text(encoding="utf-8"))
PLATFORMS = tuple(LISTED["platforms"])
PYTHONS: Mapping[str, str] = LISTED["pythons"]
TORCH = ("torch",)


@dataclass
class Collection:
    """The wheels for one platform. left_out: reasons by the version of Python that is not supported."""

    wheels: list[Path] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def pythons(self) -> list[str]:
        """The supported versions of Python."""
        return [python for python in PYTHONS if python not in self.left_out]


def collect(platform: str, folder: Path, excluded: Sequence[str] = ()) -> Collection:
    """Collect the wheels for one of Blender's platforms in a folder. excluded: names of packages to leave out.

    A version of Python is supported with all of its wheels or not at all: Blender then reports that the zip does not
    fit, instead of installing part of what is needed.
    """
    collection = Collection()
    for python in PYTHONS:
        found = []
        for name in LISTED["versions"]:
            if name in excluded:
                continue
            wheel, reason = _get(name, platform, python, folder)
            if wheel is None:
                collection.left_out[python] = reason
                break
            found.append(wheel)
        else:
            # Some wheels fit several versions.
            known = {wheel.name for wheel in collection.wheels}
            collection.wheels += [wheel for wheel in found if wheel.name not in known]
    return collection


def requirement(name: str, platform: str, python: str) -> str:
    """Return a package and its version as a requirement for pip."""
    own = LISTED["python_versions"].get(python, {}) | LISTED["platforms"][platform].get("versions", {})
    return f"{name}=={own.get(name, LISTED['versions'][name])}"


def _get(name: str, platform: str, python: str, folder: Path) -> tuple[Path | None, str]:
    """Get one wheel, from the folder or the package index; return None and the reason if there is none."""
    place = folder / platform / python / name
    place.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--only-binary=:all:", "--implementation", "cp", "--python-version", python]
    for tag in LISTED["platforms"][platform]["tags"]:
        command += ["--platform", tag]
    wanted = requirement(name, platform, python)
    command += ["--dest", str(place), wanted]
    reason = ""
    for source in (["--no-index", "--find-links", str(place)], []):
        done = subprocess.run([*command, *source], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            version = wanted.split("==")[1]
            wheel = next((path for path in place.glob("*.whl") if path.name.split("-")[1] == version), None)
            if wheel is not None:
                return wheel, ""
        reason = _reason(done.stderr)
    return None, f"no wheel of {wanted} for Python {python} ({reason})"


def _reason(stderr: str) -> str:
    """Return the last error of pip, without its list of available versions."""
    lines = [line.removeprefix("ERROR: ") for line in stderr.splitlines() if line.startswith("ERROR")]
    return lines[-1].split(" (from")[0] if lines else "pip gave no reason"
