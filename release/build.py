"""Builds the zips that an artist installs: for each platform with all wheels and without torch, and one without any.

python -m samp_blender.release.build --output dist

Blender's own builder makes and checks every zip. A platform whose wheels cannot be had here is left out, with the
reason.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from collections.abc import Sequence
from pathlib import Path

from . import wheels

ROOT = Path(__file__).resolve().parents[1]
MANIFEST = "blender_manifest.toml"
KINDS = {"": (), "light": wheels.TORCH}  # what is left out of each
LARGEST = 1_000_000


def main(arguments: Sequence[str] | None = None) -> int:
    """The exit status: 0 if all was built that could be had."""
    options = _parser().parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    told = []
    with tempfile.TemporaryDirectory() as name:
        plain = Path(name) / "plain.zip"
        _blender("build", "--source-dir", str(ROOT), "--output-filepath", str(plain))
        for kind in options.kinds:
            if kind == "bare":
                told.append(_told(_build(plain, options.output, kind), "any platform and Python, no wheels"))
                continue
            for platform in options.platforms:
                told += _for_platform(
                    plain, options.output, platform, "" if kind == "full" else kind, options
                )
    print("\n".join(told))
    return 0


def _for_platform(
    plain: Path, output: Path, platform: str, kind: str, options: argparse.Namespace
) -> list[str]:
    """Builds one platform's zip of a kind; returns what to say of it."""
    got = wheels.collect(platform, options.wheels, KINDS[kind])
    name = f"{kind or 'full'} {platform}"
    told = []
    if got.wheels:
        serves = ", ".join(wheels.PYTHONS[python] for python in got.pythons)
        told.append(_told(_build(plain, output, kind, platform, got.wheels), serves))
    for python, reason in got.left_out.items():
        told.append(f"left out: {name} for {wheels.PYTHONS[python]}: {reason}")
    return told


def _build(
    plain: Path, output: Path, kind: str, platform: str | None = None, brought: Sequence[Path] = ()
) -> Path:
    """One zip: the plain one's content with these wheels and a manifest that names them; checked."""
    with tempfile.TemporaryDirectory(dir=plain.parent) as name:
        source = Path(name)
        with zipfile.ZipFile(plain) as archive:
            archive.extractall(source)
        text = (source / MANIFEST).read_text(encoding="utf-8")
        (source / MANIFEST).write_text(manifest(text, platform, brought), encoding="utf-8")
        (source / "wheels").mkdir()
        for wheel in brought:
            _link(wheel, source / "wheels" / wheel.name)
        path = output / zip_name(tomllib.loads(text), kind, platform)
        path.unlink(missing_ok=True)
        _blender("build", "--source-dir", str(source), "--output-filepath", str(path))
    _blender("validate", str(path))
    return path


def manifest(text: str, platform: str | None, brought: Sequence[Path]) -> str:
    """The manifest of a zip: the repository's, with its platform and its wheels."""
    lines = []
    if platform is not None:
        lines.append(f"platforms = {json.dumps([platform])}")
    if brought:
        lines.append("wheels = " + json.dumps([f"./wheels/{wheel.name}" for wheel in brought], indent=2))
    head, table, rest = text.partition("\n[permissions]")
    return head + "".join(f"{line}\n" for line in lines) + table + rest


def zip_name(facts: dict, kind: str, platform: str | None) -> str:
    """As Blender names it, with the kind: samp-light-0.1.0-linux_x64.zip."""
    parts = [facts["id"], kind, facts["version"], (platform or "").replace("-", "_")]
    return "-".join(part for part in parts if part) + ".zip"


def _link(source: Path, place: Path) -> None:
    """A file at a second place, without another copy of it where the disk allows."""
    try:
        os.link(source, place)
    except OSError:
        shutil.copyfile(source, place)


def _told(path: Path, serves: str) -> str:
    return f"{path}  {path.stat().st_size / LARGEST:.1f} MB  ({serves})"


def _blender(*arguments: str) -> None:
    """Runs the builder that comes with Blender. Its complaint, if any, ends the program."""
    import bpy

    builder = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    done = subprocess.run(
        [sys.executable, str(builder), *arguments], capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"Blender's builder refuses {arguments[-1]}:\n{done.stdout}{done.stderr}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder for the zips")
    parser.add_argument(
        "--wheels", type=Path, default=ROOT / "cache" / "wheels", help="where wheels are kept"
    )
    parser.add_argument("--platforms", nargs="+", choices=wheels.PLATFORMS, default=wheels.PLATFORMS)
    parser.add_argument(
        "--kinds", nargs="+", choices=("full", "light", "bare"), default=("full", "light", "bare")
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
