"""Measure finished takes of the method in the test rooms, to compare with the raw network.

python -m samp_blender.training.scene_gan.tables.finished --corpus cache/rooms --weights RUN --output finished.json
    --rooms 60 --cameras 5 --seeds 4 --seconds 10

The character is placed in view of a random camera. Prints the share of takes generated within 8 draws a window, draws,
time, stance slide, jerk at the joins and overall, and APD of the takes of a camera. An interrupted run is resumed.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np

from ....models.scene_gan import networks
from ....samp_addon.errors import SampError
from ....samp_addon.evaluation import diversity, feet, metrics
from ....samp_addon.methods.method import Draw
from ....samp_addon.methods.scene_gan.improvisation import OVERLAP
from ....samp_addon.methods.scene_gan.method import SceneGanMethod
from ....samp_addon.methods.scene_view import SceneView
from ....samp_addon.methods.step import Step
from ....samp_addon.methods.take import Take
from ....samp_addon.motion import Motion
from ....samp_addon.scene.camera_view import CameraView
from ....samp_addon.scene.geometry import SceneGeometry
from ...rooms.corpus import store
from ...rooms.make import split_of
from ..data import room_pictures, room_windows

STRIDE = 64 - OVERLAP  # frames between two joins


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


def jerk_at_joins(motion: Motion) -> float:
    """Return the 99th percentile of the joints' jerk in the frames around the joins of windows, m/s^3."""
    joins = np.arange(64 - OVERLAP, len(motion) - 4, STRIDE)
    rows = np.unique((joins[:, None] + np.arange(-2, OVERLAP + 3)).ravel())
    joints = motion.forward_kinematics()[0][:, :22]
    found = np.linalg.norm(np.diff(joints, n=3, axis=0), axis=-1) * motion.fps**3
    rows = rows[rows < len(found)]
    return float(np.percentile(found[rows], 99)) if len(rows) else 0.0


def numbers(take: Take) -> dict[str, float | None]:
    """Return the measures of one take."""
    found = feet.measures(take.motion, take.floor)
    return {
        "jerk_m_s3": metrics.jerk(take.motion), "jerk_at_joins_m_s3": jerk_at_joins(take.motion),
        "way_m": float(np.linalg.norm((take.motion.root[-1] - take.motion.root[0])[[0, 2]])),
        "remarks": len(take.remarks), **found,
    }  # fmt: skip


def of_room(method: SceneGanMethod, data: store.RoomData, options: argparse.Namespace) -> list[dict]:
    """Return a row for each camera of a room."""
    rng = np.random.default_rng([options.seed, int(data.folder.name)])
    triangles = data.room.triangles
    geometry = SceneGeometry(triangles, np.zeros(len(triangles), np.int32), ("Room",))
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
        rows.append({
            "camera": view.name, "asked": options.seeds, "made": len(takes), "reasons": reasons,
            "cpu_seconds_a_take": (time.process_time() - began) / options.seeds,
            "apd": diversity.diversity_in_time([take.motion for take in takes]),
            "takes": [numbers(take) for take in takes],
        })  # fmt: skip
    return rows


def summary(rows: list[dict]) -> dict[str, float]:
    """Return the means over all takes and cameras."""
    takes = [take for row in rows for take in row["takes"]]
    mean = (
        lambda name: float(np.mean([t[name] for t in takes if t[name] is not None]))
        if takes
        else float("nan")
    )
    names = [name for name in (takes[0] if takes else {}) if name != "remarks"]
    return {
        "made": sum(row["made"] for row in rows) / max(sum(row["asked"] for row in rows), 1),
        "cpu_seconds_a_take": float(np.mean([row["cpu_seconds_a_take"] for row in rows])),
        "apd": float(np.mean([row["apd"] for row in rows])),
        **{name: mean(name) for name in names},
    }


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
            print(folder.name, summary(done[folder.name]), flush=True)
    print(json.dumps(summary([row for rows in done.values() for row in rows]), indent=1))


if __name__ == "__main__":
    main()
