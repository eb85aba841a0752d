"""Workbench renders of a scene, with or without a window."""

from __future__ import annotations

import ctypes
import functools
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

from ...errors import SampError

_SURFACELESS = 0x31DD  # EGL_PLATFORM_SURFACELESS_MESA
PACKAGES = "libegl1 libgl1-mesa-dri"


@functools.cache
def offscreen_works() -> bool:
    """Return whether offscreen rendering works. Without libEGL Blender aborts the whole process."""
    if not bpy.app.background or sys.platform != "linux":
        return True
    try:
        egl = ctypes.CDLL("libEGL.so.1")
        egl.eglGetPlatformDisplay.restype = ctypes.c_void_p
        egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
        display = egl.eglGetPlatformDisplay(_SURFACELESS, None, None)
        return bool(display and egl.eglInitialize(display, None, None))
    except (OSError, AttributeError):
        return False


def prepare(scene: bpy.types.Scene, width: int, height: int) -> None:
    """Set the scene up for Workbench pictures of width x height pixels."""
    if not offscreen_works():
        raise SampError(f"Pictures cannot be rendered here: install the packages {PACKAGES}.")
    render = scene.render
    render.engine = "BLENDER_WORKBENCH"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.film_transparent = False
    scene.display.render_aa = "FXAA"
    scene.display.light_direction = (0.35, 0.87, 0.35)  # the second component is up
    shading = scene.display.shading
    shading.light, shading.studio_light = "STUDIO", "paint.sl"
    shading.color_type = "MATERIAL"
    shading.show_shadows = True
    shading.shadow_intensity = 0.35
    shading.show_cavity = True
    shading.show_backface_culling = True
    scene.view_settings.view_transform, scene.view_settings.exposure = "Standard", 0.5
    if scene.world is None:
        scene.world = bpy.data.worlds.new("SAMP backdrop")
    scene.world.color = (0.56, 0.58, 0.60)


def stamp(scene: bpy.types.Scene, text: str) -> None:
    """Burn text into the corner of the next picture."""
    render = scene.render
    for name in dir(render):
        if name.startswith("use_stamp_"):
            setattr(render, name, False)
    render.use_stamp = render.use_stamp_note = True
    render.stamp_note_text = text
    render.stamp_font_size = 18
    render.stamp_foreground = (1, 1, 1, 1)
    render.stamp_background = (0.1, 0.1, 0.1, 0.7)


def picture(scene: bpy.types.Scene) -> np.ndarray:
    """Render the scene's current frame as (H, W, 3), uint8, top row first."""
    with tempfile.TemporaryDirectory() as folder:
        settings = scene.render.image_settings
        settings.file_format, settings.color_mode = "PNG", "RGB"
        settings.compression = 15
        path = str(Path(folder) / "picture.png")
        bpy.ops.render.render(scene=scene.name)
        # write_still would print a line for every picture.
        bpy.data.images["Render Result"].save_render(path, scene=scene)
        return read_png(path)


def read_png(path: str | Path) -> np.ndarray:
    """Read a picture file as (H, W, 3), uint8, top row first."""
    image = bpy.data.images.load(str(path))
    try:
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        rgb = pixels.reshape(height, width, image.channels)[::-1, :, :3]
        return np.round(rgb * 255).astype(np.uint8)
    finally:
        bpy.data.images.remove(image)


def write_png(path: str | Path, pixels: np.ndarray) -> None:
    """Write (H, W, 3), uint8, top row first, as a PNG file."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("SAMP picture", width, height)
    try:
        rgba = np.ones((height, width, 4), np.float32)
        rgba[..., :3] = pixels[::-1] / 255.0
        image.pixels.foreach_set(rgba.ravel())
        image.filepath_raw, image.file_format = str(path), "PNG"
        image.save()
    finally:
        bpy.data.images.remove(image)
