"""Benchmark of casts: four characters at a table, two in opposite directions through a door, eight in one batch.

python -m samp_blender.benchmarks.cast --rooms 50 --seeds 50 --output cast.json

Overlaps are measured by the skins: vertices of one body inside the other, in each frame in which their balls are near.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ..samp_addon.body import human
from ..samp_addon.body.balls import Track
from ..samp_addon.evaluation.between_bodies import over_time
from ..samp_addon.frames import yaw_direction
from ..samp_addon.methods.scene_view import SceneView
from ..samp_addon.motion import Motion
from ..samp_addon.pipeline.cast.cast import Cast, Member
from ..samp_addon.pipeline.cast.cast_take import CastTake, track
from ..samp_addon.pipeline.cast.directing import run
from ..samp_addon.pipeline.cast.role import CastWork, Role
from ..samp_addon.pipeline.job import Job
from ..samp_addon.scene.geometry import SceneGeometry

OVERLAP, SEATED_WITHIN = 0.02, 0.2
NEAR = 0.06
"""Distance between balls below which the skins are compared, metres."""
DOOR = 0.8


def box(low: Sequence[float], high: Sequence[float]) -> np.ndarray:
    """Return the outward triangles (12, 3, 3) of a box, network frame."""
    low, high = np.array(low, float), np.array(high, float)
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)])
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return np.array([[corners[q[0]], corners[q[k]], corners[q[k + 1]]] for q in quads for k in (1, 2)])


def chair(at: np.ndarray, yaw: float, rng: np.random.Generator) -> np.ndarray:
    """Return the triangles (F, 3, 3) of a random chair at a position (3,), facing yaw, radians."""
    w, d, h = rng.uniform(0.42, 0.5), rng.uniform(0.42, 0.48), rng.uniform(0.43, 0.47)
    parts = [box((-w / 2, h - 0.05, -d / 2), (w / 2, h, d / 2))]
    parts.append(box((-w / 2, h, -d / 2), (w / 2, h + 0.45, -d / 2 + 0.04)))
    parts += [
        box((x, 0, z), (x + 0.04, h - 0.05, z + 0.04))
        for x in (-w / 2, w / 2 - 0.04)
        for z in (-d / 2, d / 2 - 0.04)
    ]
    ahead = yaw_direction(yaw)
    turn = np.stack([np.cross([0.0, 1.0, 0.0], ahead), [0.0, 1.0, 0.0], ahead])
    return np.concatenate(parts) @ turn + at


def dining_room(seed: int) -> tuple[SceneGeometry, list[str]]:
    """Return a room with a table and four slightly pulled out chairs, two on each long side or one on each side."""
    rng = np.random.default_rng(seed)
    long, wide = rng.uniform(1.3, 1.8), rng.uniform(0.75, 0.95)
    pieces = [("Floor", box((-4, -0.1, -4), (4, 0, 4)))]
    top = [box((-long / 2, 0.70, -wide / 2), (long / 2, 0.74, wide / 2))]
    for x in (-long / 2, long / 2 - 0.06):
        top += [box((x, 0, z), (x + 0.06, 0.70, z + 0.06)) for z in (-wide / 2, wide / 2 - 0.06)]
    pieces.append(("Table", np.concatenate(top)))
    pulled = rng.uniform(0.3, 0.5)  # a chair under the table would have to be pulled out first
    if rng.random() < 0.5:
        spots = [
            (s * long / 4, t * (wide / 2 + pulled), 0 if t < 0 else np.pi) for s in (-1, 1) for t in (-1, 1)
        ]
    else:
        spots = [(0, t * (wide / 2 + pulled), 0 if t < 0 else np.pi) for t in (-1, 1)]
        spots += [(t * (long / 2 + pulled), 0, np.pi / 2 if t < 0 else -np.pi / 2) for t in (-1, 1)]
    for number, (x, z, yaw) in enumerate(spots):
        pieces.append((f"Chair {number}", chair(np.array([x, 0.0, z]), yaw + rng.normal(0, 0.1), rng)))
    return SceneGeometry.from_objects(pieces), [f"Chair {k}" for k in range(4)]


def table(seed: int) -> dict:
    """Return the measures of four characters at a table."""
    scene, chairs = dining_room(seed)
    rng = np.random.default_rng(seed + 1)
    views = tuple((SceneView(scene, scene.triangles_of([name]), (name,)),) for name in chairs)
    roles = []
    for number in range(4):
        angle = np.pi / 2 * number + rng.uniform(-0.5, 0.5)
        place = 2.9 * np.array([np.sin(angle), 0.0, np.cos(angle)])
        job = Job(action="sit", target=chairs[0], seed=seed, hold=1.0)
        member = Member(job, f"Person {number}", targets=tuple(chairs))
        role = Role(member, tuple(chairs), views, human.load())
        roles.append(role.starting((place, float(angle + np.pi))))
    take, seconds = _timed(CastWork(Cast(tuple(r.member for r in roles), seed), roles))
    found = measures(take)
    seated = [
        np.linalg.norm((made.motion.root[-1] - made.goal.position)[[0, 2]]) < SEATED_WITHIN
        for made in take.takes.values()
    ]
    targets = set(take.targets.values())
    return found | {"seated": int(sum(seated)), "distinct": len(targets), "seconds": seconds}


def door(seed: int) -> dict:
    """Return the measures of two characters that walk through one door in opposite directions."""
    rng = np.random.default_rng(seed)
    gap = DOOR / 2
    walls = [box((-3, 0, -0.06), (-gap, 2.5, 0.06)), box((gap, 0, -0.06), (3, 2.5, 0.06))]
    walls.append(box((-gap, 2.1, -0.06), (gap, 2.5, 0.06)))
    pieces = [("Floor", box((-3, -0.1, -4), (3, 0, 4))), ("Wall", np.concatenate(walls))]
    scene = SceneGeometry.from_objects(pieces)
    roles = []
    for number, side in enumerate((-1, 1)):
        start = np.array([rng.uniform(-1.5, 1.5), 0.0, side * rng.uniform(1.5, 3.2)])
        end = np.array([rng.uniform(-1.5, 1.5), 0.0, -side * rng.uniform(1.5, 3.2)])
        job = Job(action="walk", to=(0.0, 0.0, 0.0), seed=seed, hold=1.0)
        view = SceneView(scene, start=(start, 0.0 if side < 0 else np.pi), destination=(end, None))
        roles.append(Role(Member(job, f"Person {number}"), ("",), ((view,),), human.load()))
    take, seconds = _timed(CastWork(Cast(tuple(r.member for r in roles), seed), roles))
    arrived = [
        np.linalg.norm((made.motion.root[-1] - made.goal.position)[[0, 2]]) < SEATED_WITHIN
        for made in take.takes.values()
    ]
    waits = sorted(take.waits.values())
    return measures(take) | {
        "arrived": int(sum(arrived)),
        "longest_wait": waits[-1] if waits else None,
        "seconds": seconds,
    }


def batch(count: int, seed: int) -> float:
    """Return the seconds to generate ``count`` characters that walk across a hall in parallel."""
    scene = SceneGeometry.from_objects([("Floor", box((-8, -0.1, -3), (8, 0, 3)))])
    roles = []
    for number in range(count):
        x = 1.5 * (number - (count - 1) / 2)
        view = SceneView(
            scene, start=(np.array([x, 0.0, -2.0]), 0.0), destination=(np.array([x, 0.0, 2.0]), None)
        )
        job = Job(action="walk", to=(0.0, 0.0, 0.0), seed=seed, hold=1.0)
        roles.append(Role(Member(job, f"Person {number}"), ("",), ((view,),), human.load()))
    return _timed(CastWork(Cast(tuple(r.member for r in roles), seed), roles))[1]


def measures(take: CastTake) -> dict:
    """Return the largest mutual penetration of the skins, and the number of frames beyond OVERLAP."""
    motions, body = {k: made.motion for k, made in take.takes.items()}, human.load()
    frames = max((len(motion) for motion in motions.values()), default=1)
    deepest, met = 0.0, np.zeros(frames, dtype=bool)
    numbers = sorted(motions)
    tracks: dict[int, Track] = {k: track(motions[k], body, motions[k].fps) for k in numbers}
    for i, a in enumerate(numbers):
        for b in numbers[i + 1 :]:
            near = np.flatnonzero(over_time(tracks[a], tracks[b]) > -NEAR)
            for frame in near:
                depth = skins(motions[a], motions[b], frame)
                deepest, met[frame] = max(deepest, depth), met[frame] | (depth > OVERLAP)
    return {
        "takes": len(motions),
        "failures": list(take.failures.values()),
        "deepest_cm": round(100 * deepest, 2),
        "frames": frames,
        "overlapping": int(met.sum()),
        "warned": any("is up to" in remark for made in take.takes.values() for remark in made.remarks),
    }


def skins(a: Motion, b: Motion, frame: int) -> float:
    """Return the mutual penetration, metres, of two bodies in a frame: vertices of one behind the other's skin."""
    body, deepest = human.load(), 0.0
    points = [_skin(body, motion, frame) for motion in (a, b)]
    for one, two in ((0, 1), (1, 0)):
        low, high = points[two].min(0), points[two].max(0)
        inside = points[one][((points[one] > low) & (points[one] < high)).all(1)]
        if len(inside):
            _, nearest = cKDTree(points[two]).query(inside)
            normals = _normals(points[two], body.faces)[nearest]
            behind = ((points[two][nearest] - inside) * normals).sum(1)
            deepest = max(deepest, float(behind.max()))
    return deepest


def _normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the outward unit normals (V, 3) of a skin."""
    total = np.zeros_like(points)
    for a, b, c in ((0, 1, 2), (0, 2, 3)):
        corners = faces[:, [a, b, c]]
        area = np.cross(
            points[corners[:, 1]] - points[corners[:, 0]], points[corners[:, 2]] - points[corners[:, 0]]
        )
        for k in range(3):
            np.add.at(total, corners[:, k], area)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def _skin(body: human.Human, motion: Motion, frame: int) -> np.ndarray:
    row = min(frame, len(motion) - 1)
    pose = replace(motion, contacts=None, actions=None).pose_slice(slice(row, row + 1))
    return human.skin(body, pose)[0].astype(np.float64)


def _timed(work: CastWork) -> tuple[CastTake, float]:
    begun = time.perf_counter()
    (take,) = run(work)
    return take, round(time.perf_counter() - begun, 2)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rooms", type=int, default=3)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument(
        "--batch", type=int, default=8, help="characters in one batch; 0 omits the measurement"
    )
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    found: dict = {"table": [], "door": []}
    for name, measure, count in (("table", table, options.rooms), ("door", door, options.seeds)):
        for seed in range(count):
            found[name].append(measure(seed))
            print(name, seed, json.dumps(found[name][-1]), flush=True)
            _write(options.output, found)
        rows = found[name]
        frames, over = sum(row["frames"] for row in rows), sum(row["overlapping"] for row in rows)
        if rows:
            print(
                f"{name}: {over} of {frames} frames overlap by more than {100 * OVERLAP:.0f} cm", flush=True
            )
    if options.batch:
        batch(1, 0)  # warm up, so that loading and caching are not compared
        found["batch"] = {"one": batch(1, 1), "count": options.batch, "all": batch(options.batch, 1)}
        print("batch", json.dumps(found["batch"]), flush=True)
    _write(options.output, found)


def _write(path: Path | None, found: dict) -> None:
    if path is not None:
        path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
