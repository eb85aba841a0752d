"""The demo: three takes of sitting on the sofa of a furnished room, and a walk. Run by `make demo`.

Writes demo.blend, report.json, a contact sheet of each take and a short film to this folder.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import bpy
import build_room
import numpy as np
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.render import contact_sheet, movie, workbench
from samp_blender.samp_addon.blender.takes import baking, reporting
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.pipeline.driver import Toolbox
from samp_blender.samp_addon.pipeline.job import Job

HERE = Path(__file__).resolve().parent
SIT = Job(action="sit", target="Sofa", start=(-0.2, -2.3, 0.0, 200.0), seed=1, variants=3, hold=2.5)
WALK = Job(action="walk", to=(2.2, -1.6, 0.0, 0.0), start=(-2.7, -0.2, 0.0, 120.0), seed=1, hold=1.0)
VIEWS = (contact_sheet.VIEWS[0], *contact_sheet.CLOSE_VIEWS)
FILM_SIZE, FILM_STEP = (640, 360), 2
TILES = 12  # frames per view


def bake(tools: Toolbox | None) -> baking.Result:
    """Furnish an empty file and bake all takes onto one character; the first one is active."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    build_room.build(scene)
    sits = baking.run(bpy.context, SIT, tools=tools)
    walks = baking.run(bpy.context, WALK, tools=tools)
    keyframes.activate_action(sits.owner, sits.actions[0])
    variants, actions = sits.variants + walks.variants, sits.actions + walks.actions
    scene.frame_end = max(variant["frame_end"] for variant in variants)
    return baking.Result(sits.owner, actions, variants, sits.failures + walks.failures)


def file_name(variant: dict) -> str:
    """Return the file name of a take's contact sheet."""
    return variant["action_name"].lower().replace(" ", "_") + ".png"


def sheet(owner: bpy.types.Object, action: bpy.types.Action, path: Path) -> None:
    """Write the contact sheet of a take: an overview, then close-ups from two sides."""
    scene = bpy.context.scene
    keyframes.activate_action(owner, action)
    take = keyframes.read_motion(owner, action, scene=scene)
    first = int(action.frame_range[0])
    contact_sheet.contact_sheet(
        scene,
        contact_sheet.Track.of(take),
        lambda frame: scene.frame_set(first + frame),
        path,
        fps=take.fps,
        count=TILES,
        views=VIEWS,
    )


def film(owner: bpy.types.Object, action: bpy.types.Action, path: Path) -> None:
    """Write a film of a take from the room's camera."""
    scene = bpy.context.scene
    keyframes.activate_action(owner, action)
    workbench.prepare(scene, *FILM_SIZE)
    scene.render.use_stamp = False
    first, last = (int(frame) for frame in action.frame_range)

    def images() -> Iterator[np.ndarray]:
        for frame in range(first, last + 1, FILM_STEP):
            scene.frame_set(frame)
            yield workbench.picture(scene)

    with contact_sheet.shadows_of_bodies(scene):
        movie.write_movie(path, images(), keyframes.frames_per_second(scene) / FILM_STEP)


def main(folder: Path = HERE, tools: Toolbox | None = None) -> int:
    """Make the demo and return the exit status."""
    begun = time.perf_counter()
    try:
        result = bake(tools)
        report = reporting.report(result.variants, [vars(failure) for failure in result.failures])
        (folder / "report.json").write_text(json.dumps(report, indent=1) + "\n")
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "demo.blend"), copy=True)
        print(f"Baked {len(result.actions)} takes in {time.perf_counter() - begun:.1f} s")
        camera = bpy.context.scene.camera
        for variant, action in zip(result.variants, result.actions, strict=True):
            sheet(result.owner, action, folder / file_name(variant))
            numbers = variant["metrics"]
            away, turned = numbers["position_error_cm"], numbers["rotation_error_deg"]
            print(f"{file_name(variant)}: {away:.1f} cm and {turned:.1f} deg from the goal")
        bpy.context.scene.camera = camera
        film(result.owner, result.actions[0], folder / "demo.mp4")
    except SampError as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    for failure in result.failures:
        print(f"demo: seed {failure.seed}: {failure.message}", file=sys.stderr)
    print(f"All files are in {folder}, after {time.perf_counter() - begun:.0f} s")
    return int(bool(result.failures))


if __name__ == "__main__":
    sys.exit(main())
