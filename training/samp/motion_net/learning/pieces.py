"""Weights split into files of limited size, and their assembly.

python -m samp_blender.training.samp.motion_net.learning.pieces FOLDER OUTPUT
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import torch
from safetensors.torch import save

from .....models import weights

MOST = 16 * 2**20 - 4096  # bytes per file
CONTENTS = "contents.json"


def write(folder: Path, name: str, tensors: dict[str, torch.Tensor], scratch: Path) -> int:
    """Write tensors in half precision as NAME.0, NAME.1, ...; return the number of files.

    scratch: a folder on the same file system; files are moved from there, so that no incomplete one appears.
    """
    half = {k: (v.half() if v.is_floating_point() else v).contiguous().cpu() for k, v in tensors.items()}
    body = save(half)
    parts = [body[at : at + MOST] for at in range(0, len(body), MOST)]
    for k, part in enumerate(parts):
        (scratch / f"{name}.{k}").write_bytes(part)
    for k in range(len(parts)):
        (scratch / f"{name}.{k}").replace(folder / f"{name}.{k}")
    return len(parts)


def write_contents(folder: Path, contents: dict, scratch: Path) -> None:
    """Write the table of contents."""
    (scratch / CONTENTS).write_text(json.dumps(contents, indent=1))
    (scratch / CONTENTS).replace(folder / CONTENTS)


def join(folder: Path, output: Path) -> list[Path]:
    """Assemble the weights of every run into OUTPUT/RUN, as models/weights.py loads them; return the files' paths."""
    contents = json.loads((folder / CONTENTS).read_text())
    made = []
    for run in contents["runs"]:
        for kind, name in (("", "motion_net"), ("_encoder", "encoder")):
            parts = sorted(folder.glob(f"{run}{kind}.[0-9]"))
            if not parts:
                continue
            path = output / run / f"{name}.safetensors"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(b"".join(part.read_bytes() for part in parts))
            path.with_suffix(".sha256").write_text(weights.checksum(path) + "\n")
            made.append(path)
    return made


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    options = parser.parse_args()
    for path in join(options.folder, options.output):
        print(path)


if __name__ == "__main__":
    main()
