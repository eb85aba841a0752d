"""Copy screenshots of the last `make test-ui` into the documentation, cropped and with a reduced palette.

python docs/update_pictures.py SHOTS
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).resolve().parent / "images"
# Name in the documentation: suffix of the screenshot's name, and the crop (left, top, right, bottom) in pixels.
PICTURES = {
    "running": ("running", (240, 80, 1310, 860)),
    "refined": ("refined", (240, 80, 1310, 930)),
    "goals": ("goals_and_path", (240, 80, 1310, 930)),
    "blocking": ("sub_goals", (240, 80, 1310, 930)),
    "place": ("place_seat", (240, 80, 1310, 930)),
}
COLOURS = 128


def main(shots: Path) -> None:
    """Write the pictures in IMAGES; keep a picture whose screenshot is missing."""
    IMAGES.mkdir(exist_ok=True)
    for name, (end, box) in PICTURES.items():
        found = sorted(shots.glob(f"*_{end}.png"))
        if not found:
            print(f"There is no screenshot '{end}' in {shots}; run make test-ui.")
            continue
        picture = Image.open(found[-1]).convert("RGB").crop(box)
        picture.quantize(COLOURS).save(IMAGES / f"{name}.png", optimize=True)
        print(f"docs/images/{name}.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
