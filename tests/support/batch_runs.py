"""Runs of the batch in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


FAKES = ROOT / "tests" / "support" / "bake_with_fakes.py"


def bake(*arguments, script=FAKES, cwd=None):
    """Runs the batch; returns its status, standard output and standard error."""
    command = [sys.executable, str(script), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=300, check=False)
    return done.returncode, done.stdout, done.stderr


def load(path):
    return json.loads(Path(path).read_text())
