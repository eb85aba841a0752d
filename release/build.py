"""Build the zips to install: for each platform one with all wheels and one without torch, and one without wheels.

python -m samp_blender.release.build --output dist

Blender's own builder creates and validates each zip. Platforms whose wheels cannot be downloaded are skipped, and the
reason is printed.
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
EXCLUDED = {"": (), "light": wheels.TORCH}  # packages left out of each kind of zip
MEGABYTE = 1_000_000


def main(arguments: Sequence[str] | None = None) -> int:
    """Build the zips and return the exit status: 0 also where platforms were skipped."""
    options = _parser().parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    lines = []
    with tempfile.TemporaryDirectory() as name:
        plain = Path(name) / "plain.zip"
        _blender("build", "--source-dir", str(ROOT), "--output-filepath", str(plain))
        for kind in options.kinds:
            if kind == "bare":
                lines.append(
                    _summary(_build(plain, options.output, kind), "any platform and Python, no wheels")
                )
                continue
            for platform in options.platforms:
                lines += _for_platform(
                    plain, options.output, platform, "" if kind == "full" else kind, options
                )
    print("\n".join(lines))
    return 0


def _for_platform(
    plain: Path, output: Path, platform: str, kind: str, options: argparse.Namespace
) -> list[str]:
    """Build one kind of zip for one platform; return the lines to print."""
    got = wheels.collect(platform, options.wheels, EXCLUDED[kind])
    name = f"{kind or 'full'} {platform}"
    lines = []
    if got.wheels:
        supported = ", ".join(wheels.PYTHONS[python] for python in got.pythons)
        lines.append(_summary(_build(plain, output, kind, platform, got.wheels), supported))
    for python, reason in got.left_out.items():
        lines.append(f"left out: {name} for {wheels.PYTHONS[python]}: {reason}")
    return lines


def _build(
    plain: Path, output: Path, kind: str, platform: str | None = None, wheel_paths: Sequence[Path] = ()
) -> Path:
    """Build and validate one zip: the content of the plain one, the wheels, and a manifest that lists them."""
    with tempfile.TemporaryDirectory(dir=plain.parent) as name:
        source = Path(name)
        with zipfile.ZipFile(plain) as archive:
            archive.extractall(source)
        text = (source / MANIFEST).read_text(encoding="utf-8")
        (source / MANIFEST).write_text(manifest(text, platform, wheel_paths), encoding="utf-8")
        (source / "wheels").mkdir()
        for wheel in wheel_paths:
            _link(wheel, source / "wheels" / wheel.name)
        path = output / zip_name(tomllib.loads(text), kind, platform)
        path.unlink(missing_ok=True)
        _blender("build", "--source-dir", str(source), "--output-filepath", str(path))
    _blender("validate", str(path))
    return path


def manifest(text: str, platform: str | None, wheel_paths: Sequence[Path]) -> str:
    """Return the repository's manifest with the platform and the wheels of a zip added."""
    lines = []
    if platform is not None:
        lines.append(f"platforms = {json.dumps([platform])}")
    if wheel_paths:
        lines.append("wheels = " + json.dumps([f"./wheels/{wheel.name}" for wheel in wheel_paths], indent=2))
    head, table, rest = text.partition("\n[permissions]")
    return head + "".join(f"{line}\n" for line in lines) + table + rest


def zip_name(manifest_data: dict, kind: str, platform: str | None) -> str:
    """Return the file name by Blender's convention, with the kind: samp-light-0.1.0-linux_x64.zip."""
    parts = [manifest_data["id"], kind, manifest_data["version"], (platform or "").replace("-", "_")]
    return "-".join(part for part in parts if part) + ".zip"


def _link(source: Path, place: Path) -> None:
    """Hard-link a file, or copy it where the file system does not allow links."""
    try:
        os.link(source, place)
    except OSError:
        shutil.copyfile(source, place)


def _summary(path: Path, supported: str) -> str:
    return f"{path}  {path.stat().st_size / MEGABYTE:.1f} MB  ({supported})"


def _blender(*arguments: str) -> None:
    """Run the builder that is part of Blender; exit with its output if it fails."""
    import bpy

    builder = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    done = subprocess.run(
        [sys.executable, str(builder), *arguments], capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"Blender's builder rejected {arguments[-1]}:\n{done.stdout}{done.stderr}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder for the zips")
    parser.add_argument(
        "--wheels", type=Path, default=ROOT / "cache" / "wheels", help="folder in which wheels are cached"
    )
    parser.add_argument("--platforms", nargs="+", choices=wheels.PLATFORMS, default=wheels.PLATFORMS)
    parser.add_argument(
        "--kinds", nargs="+", choices=("full", "light", "bare"), default=("full", "light", "bare")
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
