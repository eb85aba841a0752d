"""Generate takes without a window. The command is the same under Blender and under Python with the bpy module.

blender -b ROOM.blend --python bake.py -- --action sit --target Sofa --output OUT.blend
python bake.py --scene ROOM.blend          --action sit --target Sofa --output OUT.blend
"""

import importlib.util
import os
import sys
from pathlib import Path

PACKAGE = "samp_blender"


def load_package() -> None:
    """Import the folder of this file as the package PACKAGE, installed or not."""
    root = Path(__file__).resolve().parent
    spec = importlib.util.spec_from_file_location(
        PACKAGE, root / "__init__.py", submodule_search_locations=[str(root)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = package
    spec.loader.exec_module(package)


def arguments() -> list[str]:
    """Return the arguments for this script: under Blender those after ``--``."""
    if "--" in sys.argv:
        return sys.argv[sys.argv.index("--") + 1 :]
    return [] if os.path.basename(sys.argv[0]).lower().startswith("blender") else sys.argv[1:]


def main() -> int:
    """Run the batch and return the exit status."""
    load_package()
    try:
        batch = importlib.import_module(f"{PACKAGE}.samp_addon.batch.main")
    except ImportError as error:
        name = error.name or str(error)
        print(
            f"bake: The Python package '{name}' is missing; run `make venv`, or install it.", file=sys.stderr
        )
        return 2
    return batch.main(arguments())


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    sys.stderr.flush()
    sys.exit(status)
