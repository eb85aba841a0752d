"""Generate and measure takes in rooms of boxes with held-out furniture."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ...samp_addon.errors import SampError
from ...samp_addon.evaluation import metrics, posture
from ...samp_addon.evaluation.obstacles import shared
from ...samp_addon.methods.samp.method import Samp
from ...samp_addon.methods.samp.networks import Networks
from ...samp_addon.methods.samp.request import Request
from ...samp_addon.methods.scene_view import SceneView
from ...samp_addon.methods.take import Take
from ...samp_addon.motion import Motion
from ...samp_addon.pipeline import driver
from ...samp_addon.pipeline.driver import Toolbox, Work
from ...samp_addon.pipeline.job import Job
from ...samp_addon.scene.geometry import SceneGeometry
from ...tests.support import rooms
from .. import furniture
from .tables import Estimate

FIRST_ROOM = 1000  # first seed of the rooms; benchmarks and tests use others
LONG_ENOUGH = 1.65  # least longest side (m) of furniture for lying, for a body of 1.7 m
SEATS = {"sit": ("armchair", "chair", "sofa", "stool", "bench"), "lie": ("bed", "sofa")}


@dataclass
class Results:
    """All takes of an action with their measures, and the number of failed takes.

    alike: motions of the same job. furniture: the triangles (F, 3, 3) around each take, without the floor, metres.
    scenes: with the floor. clusters: the piece or room of each take. jobs: all jobs with their piece or room.
    """

    takes: list[Take] = field(default_factory=list)
    numbers: list[dict] = field(default_factory=list)
    alike: list[list[Motion]] = field(default_factory=list)
    failed: int = 0
    furniture: list[np.ndarray] = field(default_factory=list)
    scenes: list[SceneGeometry] = field(default_factory=list)
    clusters: list[str] = field(default_factory=list)
    jobs: list[tuple[Job, SceneView, str]] = field(default_factory=list)

    @property
    def asked(self) -> int:
        """Number of requested takes."""
        return len(self.takes) + self.failed

    def values(self, key: str) -> list[float]:
        """Return a measure of all takes that have it."""
        return [numbers[key] for numbers in self.numbers if numbers.get(key) is not None]

    def estimate(self, key: str) -> Estimate | None:
        """Return a measure's mean over takes that have it, with an interval over pieces or rooms; None without any."""
        known = [numbers.get(key) is not None for numbers in self.numbers]
        if not any(known):
            return None
        clusters = [cluster for cluster, use in zip(self.clusters, known, strict=True) if use]
        return Estimate.of(self.values(key), clusters)


def held_out_seats(folder: Path, action: str = "sit", part: str = "all") -> list[furniture.piece.Piece]:
    """Return the held-out pieces for sitting or lying, with procedural ones where the library is missing.

    The list is empty where the folder is missing. part: "tuning", "final" (see furniture.library.part_of) or "all".
    """
    try:
        pieces = furniture.library.load(folder, held_out=True)
    except FileNotFoundError:
        return []
    if part != "all":
        pieces = [piece for piece in pieces if furniture.library.part_of(piece.name) == part]
    if folder == furniture.library.SHIPPED_FOLDER:
        pieces += furniture.unseen(SEATS.get(action, ()))
    fit = [piece for piece in pieces if piece.category in SEATS.get(action, ())]
    if action == "lie":
        fit = [piece for piece in fit if np.ptp(piece.triangles, axis=(0, 1)).max() >= LONG_ENOUGH]
    return fit


def view_of(room: rooms.Room, piece: furniture.piece.Piece | None) -> SceneView:
    """Return a room as a view, with a piece in place of its seat if one is given."""
    target = room.target.triangles
    if piece is not None:
        turned = rooms.turned(piece.triangles, room.target.yaw)
        target = turned + [room.target.at[0], 0.0, room.target.at[1]]
    others = [(obstacle.name, obstacle.triangles) for obstacle in room.pieces[1:]]
    scene = SceneGeometry.from_objects([("Floor", room.floor), ("Target", target), *others])
    return SceneView(scene, target, ("Target",), (room.start, room.start_yaw))


def toolbox(networks: Networks) -> Toolbox:
    """Return the driver's tools with the given networks for SAMP."""
    return Toolbox(methods={Samp.name: Samp(networks)})


def straight_on(networks: Networks) -> Networks:
    """Return the networks without the planner: requests have a straight path from start to end."""

    def generate(
        requests: Sequence[Request], progress: Callable[[float], None] = lambda share: None
    ) -> Sequence[Motion | SampError]:
        return networks.generate([replace(r, waypoints=r.waypoints[[0, -1]]) for r in requests], progress)

    return replace(networks, generate=generate)


def evaluate(
    action: str,
    count: int,
    takes: int,
    pieces: Sequence,
    networks: Networks | None = None,
    report: Callable[[str], None] = lambda line: print(line, file=sys.stderr, flush=True),
) -> Results:
    """Generate and measure takes of one action in ``count`` rooms. report: called with a line for each failure."""
    results = Results(jobs=jobs_of(action, count, takes, pieces))
    for seed, (job, view, cluster) in enumerate(results.jobs):
        try:
            made, failures = driver.run(Work(job, [view]), tools=networks and toolbox(networks))
        except SampError as error:
            report(f"{action}, room {seed}: {error}")
            results.failed += takes
            continue
        for failure in failures:
            report(f"{action}, room {seed}, seed {failure.seed}: {failure.message}")
        results.failed += len(failures)
        results.takes += made
        results.clusters += [cluster] * len(made)
        results.furniture += [view.geometry.without(("Floor",)).triangles] * len(made)
        results.scenes += [view.geometry] * len(made)
        obstacles = shared(view.geometry.triangles)
        results.numbers += [
            metrics.measure(take.motion, take.goal, obstacles, take.floor)
            | posture.measures(take.motion)
            | {"attempts": take.attempts}
            for take in made
        ]
        if len(made) > 1:
            results.alike.append([take.motion for take in made])
    return results


def jobs_of(
    action: str, count: int, takes: int, pieces: Sequence[furniture.piece.Piece]
) -> list[tuple[Job, SceneView, str]]:
    """Return the jobs of an action in ``count`` rooms, each with its view and the name of its piece or room."""
    names = [pieces[seed % len(pieces)].name if pieces else f"room {seed}" for seed in range(count)]
    return [(*_job(action, seed, takes, pieces), name) for seed, name in enumerate(names)]


def _job(action: str, seed: int, takes: int, pieces: Sequence) -> tuple[Job, SceneView]:
    """Return the job in a room, and the room's view."""
    stand_in = rooms.bed if action == "lie" else rooms.sofa if pieces else None
    room = rooms.random_room(FIRST_ROOM + seed, stand_in)
    view = view_of(room, pieces[seed % len(pieces)] if pieces else None)
    job = Job(action=action, target="Target", seed=1000 * seed, variants=takes)
    if action in ("walk", "run"):
        # The destination is the corner opposite to the start.
        place = -room.start * [0.9, 0.0, 0.9]
        job = replace(job, target="", to=(0.0, 0.0, 0.0))
        view = replace(view, target=None, parts=(), destination=(place, None))
    return job, view
