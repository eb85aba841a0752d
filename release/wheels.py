"""Gets the wheels of a platform with pip, from wherever pip is set up to look on this machine."""

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
    """The wheels for one platform. left_out: by version of Python, why it cannot be served."""

    wheels: list[Path] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def pythons(self) -> list[str]:
        """The versions of Python that are served."""
        return [python for python in PYTHONS if python not in self.left_out]


def collect(platform: str, folder: Path, leave: Sequence[str] = ()) -> Collection:
    """The wheels for one of Blender's platforms, kept in a folder. leave: names of packages that are not wanted.

    A version of Python is served with all of its wheels or not at all: Blender then says that the zip does not fit,
    instead of installing half of what is needed.
    """
    made = Collection()
    for python in PYTHONS:
        found = []
        for name in LISTED["versions"]:
            if name in leave:
                continue
            wheel, reason = _get(name, platform, python, folder)
            if wheel is None:
                made.left_out[python] = reason
                break
            found.append(wheel)
        else:
            # Some wheels serve several versions.
            known = {wheel.name for wheel in made.wheels}
            made.wheels += [wheel for wheel in found if wheel.name not in known]
    return made


def requirement(name: str, platform: str) -> str:
    """A package and its version, as pip wants it."""
    own = LISTED["platforms"][platform].get("versions", {})
    return f"{name}=={own.get(name, LISTED['versions'][name])}"


def _get(name: str, platform: str, python: str, folder: Path) -> tuple[Path | None, str]:
    """One wheel: from the folder, else from where pip looks. None and a reason where there is none."""
    place = folder / platform / python / name
    place.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--only-binary=:all:", "--implementation", "cp", "--python-version", python]
    for tag in LISTED["platforms"][platform]["tags"]:
        command += ["--platform", tag]
    wanted = requirement(name, platform)
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


def _reason(complaint: str) -> str:
    """The last thing that pip said, without the versions it would have had instead."""
    lines = [line.removeprefix("ERROR: ") for line in complaint.splitlines() if line.startswith("ERROR")]
    return lines[-1].split(" (from")[0] if lines else "pip gave no reason"
