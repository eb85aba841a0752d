"""Measure finished takes of the method in the test rooms, to compare with the raw network.

python -m samp_blender.training.scene_gan.tables.finished --corpus cache/rooms --weights RUN --output finished.json
    --rooms 60 --cameras 5 --seeds 4 --seconds 10

The character is placed in view of a random camera. Prints the shares of takes that were made and that stay on the
navmesh, time, stance slide, jerk at the joins and overall, frames in furniture, non-collision before the depth map, the
steps of walking bodies, and the APD of the takes of a camera; the last two also of captured motion there. An
interrupted run is resumed.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
import torch

from ....models.scene_gan import networks
from ....samp_addon.body import human
from ....samp_addon.errors import SampError
from ....samp_addon.evaluation import diversity
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.methods.method import Draw
from ....samp_addon.methods.scene_gan import placing
from ....samp_addon.methods.scene_gan.ground import Ground
from ....samp_addon.methods.scene_gan.improvisation import frames_of
from ....samp_addon.methods.scene_gan.method import SceneGanMethod, walkable
from ....samp_addon.methods.scene_view import SceneView
from ....samp_addon.methods.step import Step
from ....samp_addon.motion import Motion
from ....samp_addon.scene.camera_view import CameraView
from ....samp_addon.scene.geometry import SceneGeometry
from ...rooms.corpus import store
from ...rooms.make import split_of
from ..data import room_pictures, room_windows
from . import make
from .finished_numbers import gait, of_take

BETWEEN = 60  # frames between the starts of two captured motions


def views(data: store.RoomData, count: int, rng: np.random.Generator) -> list[CameraView]:
    """Return the views of a room from ``count`` cameras, each with the start of a captured window in view."""
    chosen = room_windows.of_room(data, 60, rng)
    joints = room_windows.first_joints(room_windows.motion(data, chosen), chosen["episode"])
    made, cameras, _ = room_pictures.of_room(data, joints, count, rng, colour=True)
    return [
        CameraView(f"{data.folder.name}/{k}", made["colour"][k], made["depth"][k] / 1000.0,
                   made["lens"][k].astype(np.float64), made["extrinsics"][k].astype(np.float64))
        for k in range(len(cameras))
    ]  # fmt: skip


def captured(
    data: store.RoomData, view: CameraView, options: argparse.Namespace, rng: np.random.Generator
) -> list[Motion]:
    """Return as many captured motions, as long as a take, that begin in view of a camera."""
    frames = frames_of(options.seconds)
    starts = [
        (episode, frame)
        for episode, length in enumerate(np.diff(np.array(data.bounds)))
        for frame in range(0, int(length) - frames + 1, BETWEEN)
        if placing.in_view(view, data.motion(episode, frame, 1).root * [1.0, 0.0, 1.0])[0]
    ]
    chosen = [starts[k] for k in rng.permutation(len(starts))[: options.seeds]]
    return [data.motion(*start, frames) for start in chosen]


def of_room(method: SceneGanMethod, data: store.RoomData, options: argparse.Namespace) -> list[dict]:
    """Return a row for each camera of a room."""
    rng = np.random.default_rng([options.seed, int(data.folder.name)])
    triangles = data.room.triangles
    geometry = SceneGeometry(triangles, np.zeros(len(triangles), np.int32), ("Room",))
    obstacles = Obstacles(triangles)
    step = Step(action="", method="scene_gan", settings={"seconds": options.seconds})
    rows = []
    for view in views(data, options.cameras, rng):
        began = time.process_time()
        draws = [Draw(seed, seed) for seed in range(options.seeds)]
        scene = SceneView(geometry, camera=view)
        try:
            takes, failures = method.generate(step, scene, draws, lambda stage, share: None)
            reasons = [failure.message for failure in failures]
        except SampError as error:
            takes, reasons = [], [str(error)] * options.seeds
        cpu = (time.process_time() - began) / options.seeds
        ground = Ground(walkable(scene), triangles, -human.load().floor) if takes else None
        real = captured(data, view, options, rng)
        rows.append({
            "camera": view.name, "asked": options.seeds, "made": len(takes), "reasons": reasons,
            "cpu_seconds_a_take": cpu,
            "apd": diversity.diversity_in_time([take.motion for take in takes]),
            "apd_captured": diversity.diversity_in_time(real), "gait_captured": [gait(motion) for motion in real],
            "takes": [of_take(take, view, ground, obstacles) for take in takes],
        })  # fmt: skip
    return rows


def summary(done: dict[str, list[dict]]) -> dict[str, object]:
    """Return the means over all takes and cameras of rooms, and non-collision with its interval over rooms."""
    rows = [row for found in done.values() for row in found]
    takes = [(room, take) for room, found in done.items() for row in found for take in row["takes"]]
    names = [name for name, value in (takes[0][1] if takes else {}).items() if not isinstance(value, dict)]
    of_takes = {name: [take[name] for _, take in takes if take[name] is not None] for name in names}
    real = [walk for row in rows for walk in row["gait_captured"]]
    of_real = {
        f"{name}_captured": [walk[name] for walk in real if walk[name] is not None]
        for name in (real[0] if real else ())
    }
    means = {name: [row[name] for row in rows] for name in ("cpu_seconds_a_take", "apd", "apd_captured")}
    return {
        "takes": len(takes), "made": len(takes) / max(sum(row["asked"] for row in rows), 1),
        **{name: float(np.mean(values)) for name, values in (means | of_takes | of_real).items() if values},
        "non_collision": free(takes),
    }  # fmt: skip


def free(takes: list[tuple[str, dict]]) -> dict[str, list[float]]:
    """Return the non-collision rate of takes of rooms, by radius, with its interval over rooms."""
    found = {}
    for radius in takes[0][1]["points_inside"] if takes else ():
        counts = [take["points_inside"][radius] for _, take in takes]
        rooms = np.repeat([room for room, _ in takes], [len(each) for each in counts])
        found[radius] = make.interval(torch.tensor(np.concatenate(counts)), rooms, seed=0)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--corpus", type=Path, required=True)
    parser.add_argument("--weights", type=Path, required=True, help="folder written by train.py")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--rooms", type=int, default=60)
    parser.add_argument("--cameras", type=int, default=5)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    method = SceneGanMethod(networks.load(options.weights))
    folders = [f for f in sorted((options.corpus / "rooms").iterdir()) if split_of(int(f.name)) == "test"]
    folders = [f for f in folders if all(store.has_stage(f, s) for s in ("cloud", "motion"))][: options.rooms]
    done = json.loads(options.output.read_text()) if options.output.exists() else {}
    for folder in folders:
        if folder.name not in done:
            done[folder.name] = of_room(method, store.RoomData(folder), options)
            store.write_json(options.output, done)
            print(folder.name, summary({folder.name: done[folder.name]}), flush=True)
    print(json.dumps(summary(done), indent=1))


if __name__ == "__main__":
    main()
