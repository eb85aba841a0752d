"""Render the README's film, a take of the demo, as docs/images/sit.gif.

python docs/update_film.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
from mathutils import Vector
from PIL import Image
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.render import contact_sheet, workbench

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "demo"))

import make_demo  # noqa: E402

FILM = ROOT / "docs" / "images" / "sit.gif"
TAKE = 1  # index of the take among those of the demo
FRAMES = range(90, 306, 2)  # of 30 per second: from the middle of the walk until the character is seated
SIZE = (480, 270)
CAMERA, TARGET, LENS = (3.1, -2.3, 1.95), (-0.15, 1.3, 0.72), 34.0  # metres and millimetres
DURATIONS = (70, 70, 60)  # milliseconds, in turn: 15 frames per second in steps of 10 ms
LAST = 1200  # milliseconds of the last frame
COLOURS = 256
SAMPLES = 6  # frames from which the palette is computed


def render() -> list[Image.Image]:
    """Return the frames of the film."""
    result = make_demo.bake(None)
    scene = bpy.context.scene
    camera = scene.camera
    camera.location = CAMERA
    camera.rotation_euler = (Vector(TARGET) - Vector(CAMERA)).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens = LENS
    keyframes.activate_action(result.owner, result.actions[TAKE])
    workbench.prepare(scene, *SIZE)
    scene.render.use_stamp = False
    pictures = []
    with contact_sheet.shadows_of_bodies(scene):
        for frame in FRAMES:
            scene.frame_set(frame)
            pictures.append(Image.fromarray(workbench.picture(scene)))
    return pictures


def write(pictures: list[Image.Image], path: Path) -> None:
    """Write pictures as an endless GIF with one palette, so that only the parts that change are stored."""
    width, height = pictures[0].size
    samples = pictures[:: max(1, len(pictures) // SAMPLES)]
    mosaic = Image.new("RGB", (width, height * len(samples)))
    for number, sample in enumerate(samples):
        mosaic.paste(sample, (0, number * height))
    palette = mosaic.quantize(COLOURS)
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    durations = [DURATIONS[number % len(DURATIONS)] for number in range(len(frames) - 1)] + [LAST]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=durations, loop=0, disposal=1)


if __name__ == "__main__":
    write(render(), FILM)
    print(FILM.relative_to(ROOT))
