"""bake.py with the networks stood in for, so that the batch can be tested as a process and fast."""

import importlib
import runpy
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
bake = runpy.run_path(str(ROOT / "bake.py"))
bake["load_package"]()
batch = importlib.import_module(f"{bake['PACKAGE']}.samp_addon.batch.main")
fakes = importlib.import_module("fakes")

if __name__ == "__main__":
    sys.exit(batch.main(bake["arguments"](), tools=fakes.TOOLS))
