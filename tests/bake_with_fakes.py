"""bake.py with the networks stood in for, so that the batch can be tested as a process and fast."""

import importlib
import runpy
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))
bake = runpy.run_path(str(ROOT / "bake.py"))
bake["load_package"]()
batch = importlib.import_module(f"{bake['PACKAGE']}.samp_addon.blender.batch")
fakes = importlib.import_module("fakes")

if __name__ == "__main__":
    sys.exit(batch.main(bake["arguments"](), tools=fakes.TOOLS))
