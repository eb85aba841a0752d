"""The folder that is sent to a farm: jobs file, scene, and what each engine wants beside them."""

from __future__ import annotations

import json
import platform
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ....errors import SampError
from . import lines

TEMPLATE = Path(__file__).resolve().parents[4] / "farm" / "openjd" / "template.yaml"
BAKE_SCRIPT = Path(__file__).resolve().parents[4] / "bake.py"
JOBS, OUTPUT = "jobs.jsonl", "output"
JOB_TYPE = "samp-bake"
"""Name that Flamenco gives the job type of farm/flamenco/samp_bake.js."""


@dataclass(frozen=True)
class Workers:
    """What the workers have. blender: Blender, or a Python with bpy. bake_script: bake.py; empty for this add-on's
    own (Flamenco: for its variable {samp_bake}). chunk: lines for each task."""

    blender: str = "blender"
    bake_script: str = ""
    chunk: int = 25


@dataclass(frozen=True)
class Bundle:
    """A folder to send. name: of the job in the farm's manager. scene: the .blend in it. count: of the jobs file's
    lines."""

    folder: Path
    name: str
    scene: Path
    count: int

    @property
    def jobs(self) -> Path:
        """The jobs file; names in it begin in the folder."""
        return self.folder / JOBS

    @property
    def output(self) -> Path:
        """The folder that gets reports and takes."""
        return self.folder / OUTPUT

    def files(self) -> list[Path]:
        """Return the scene and what was packed with it."""
        home = self.scene.relative_to(self.folder).parts[0]
        if (self.folder / home).is_file():
            return [self.scene]
        return sorted(path for path in (self.folder / home).rglob("*") if path.is_file())


def write(bundle: Bundle, texts: Sequence[str], workers: Workers) -> None:
    """Write jobs file and job descriptions into the folder, which holds the scene. Raise SampError."""
    try:
        bundle.output.mkdir(parents=True, exist_ok=True)
        bundle.jobs.write_text("".join(f"{text}\n" for text in texts), encoding="utf-8")
        if lines.count(bundle.jobs) != bundle.count:
            raise SampError(f"'{bundle.jobs}' is not what was written; choose another folder.")
        shutil.copyfile(TEMPLATE, bundle.folder / "template.yaml")
        values = [{"name": name, "value": value} for name, value in parameters(bundle, workers).items()]
        _write_json(bundle.folder / "parameter_values.json", {"parameterValues": values})
        _write_json(bundle.folder / "asset_references.json", _assets(bundle))
        _write_json(bundle.folder / "flamenco.json", flamenco_job(bundle, workers))
    except OSError as error:
        raise SampError(
            f"'{bundle.folder}' cannot be written ({error.strerror}); choose another folder."
        ) from error


def parameters(bundle: Bundle, workers: Workers) -> dict[str, Any]:
    """Return the parameters of farm/openjd/template.yaml."""
    return {
        "JobName": bundle.name[:100],
        "JobsFile": str(bundle.jobs),
        "Lines": bundle.count,
        "OutputFolder": str(bundle.output),
        "ChunkSize": workers.chunk,
        "Blender": workers.blender,
        "BakeScript": workers.bake_script or str(BAKE_SCRIPT),
        "OnFailure": "report",
    }


def flamenco_job(bundle: Bundle, workers: Workers) -> dict[str, Any]:
    """Return the job as Flamenco's API takes it (POST /api/v3/jobs), with the settings of samp_bake.js."""
    return {
        "name": f"SAMP {bundle.name}",
        "type": JOB_TYPE,
        "priority": 50,
        "submitter_platform": platform.system().lower(),
        "settings": {
            "jobs_file": bundle.jobs.as_posix(),
            "lines": bundle.count,
            "chunk_size": workers.chunk,
            "output_folder": bundle.output.as_posix(),
            "on_failure": "report",
            "bake_script": workers.bake_script or "{samp_bake}",
            "blendfile": bundle.scene.as_posix(),
        },
        "metadata": {"project": bundle.name},
    }


def _assets(bundle: Bundle) -> dict[str, Any]:
    """Return which files a job of AWS Deadline Cloud takes to its workers, and brings back."""
    return {
        "assetReferences": {
            "inputs": {"filenames": [str(path) for path in bundle.files()], "directories": []},
            "outputs": {"directories": [str(bundle.output)]},
            "referencedPaths": [],
        }
    }


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
