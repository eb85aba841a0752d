"""Takes in rooms of boxes around held-out furniture, and what each of them measures."""

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

FIRST_ROOM = 1000  # seed; the rooms of the judge and of the tests are others
LONG_ENOUGH = 1.65  # metres of the longest side of what somebody of 1.7 m is asked to lie on
SEATS = {"sit": ("armchair", "chair", "sofa", "stool", "bench"), "lie": ("bed", "sofa")}


@dataclass
class Results:
    """All takes of an action with their measures, those of the same job together, and how many were not made.

    furniture: the triangles (F, 3, 3) around each take, without the floor. scenes: all around each. clusters: the
    piece or room of each. jobs: all that was asked for, with the piece or room.
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
        """How many takes were asked for."""
        return len(self.takes) + self.failed

    def values(self, key: str) -> list[float]:
        """A measure of all takes that have it."""
        return [numbers[key] for numbers in self.numbers if numbers.get(key) is not None]

    def estimate(self, key: str) -> Estimate | None:
        """A measure's mean over all takes that have it, its interval over pieces or rooms; None without any."""
        known = [numbers.get(key) is not None for numbers in self.numbers]
        if not any(known):
            return None
        clusters = [cluster for cluster, use in zip(self.clusters, known, strict=True) if use]
        return Estimate.of(self.values(key), clusters)


def held_out_seats(folder: Path, action: str = "sit", part: str = "all") -> list[furniture.piece.Piece]:
    """The pieces to sit or lie on that no training has seen, with procedural ones where the library is missing.

    None where the folder is missing. part: "tuning", "final" (see furniture.library.part_of) or "all".
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
    """A room with a real piece in place of its seat, if there is one."""
    target = room.target.triangles
    if piece is not None:
        turned = rooms.turned(piece.triangles, room.target.yaw)
        target = turned + [room.target.at[0], 0.0, room.target.at[1]]
    others = [(obstacle.name, obstacle.triangles) for obstacle in room.pieces[1:]]
    scene = SceneGeometry.from_objects([("Floor", room.floor), ("Target", target), *others])
    return SceneView(scene, target, ("Target",), (room.start, room.start_yaw))


def toolbox(networks: Networks) -> Toolbox:
    """Return the driver's tools with these networks for SAMP."""
    return Toolbox(methods={Samp.name: Samp(networks)})


def straight_on(networks: Networks) -> Networks:
    """The same networks without the planner: requests go straight from the start to the end of their way."""

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
    tell: Callable[[str], None] = lambda line: print(line, file=sys.stderr, flush=True),
) -> Results:
    """Takes of one action in `count` rooms. tell: is told of what cannot be made."""
    results = Results(jobs=jobs_of(action, count, takes, pieces))
    for seed, (job, view, cluster) in enumerate(results.jobs):
        try:
            made, failures = driver.run(Work(job, [view]), tools=networks and toolbox(networks))
        except SampError as error:
            tell(f"{action}, room {seed}: {error}")
            results.failed += takes
            continue
        for failure in failures:
            tell(f"{action}, room {seed}, seed {failure.seed}: {failure.message}")
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
    """Return the jobs of an action in ``count`` rooms, the rooms, and the piece or room of each as a name."""
    names = [pieces[seed % len(pieces)].name if pieces else f"room {seed}" for seed in range(count)]
    return [(*_job(action, seed, takes, pieces), name) for seed, name in enumerate(names)]


def _job(action: str, seed: int, takes: int, pieces: Sequence) -> tuple[Job, SceneView]:
    """What is asked for in a room, and the room."""
    stand_in = rooms.bed if action == "lie" else rooms.sofa if pieces else None
    room = rooms.random_room(FIRST_ROOM + seed, stand_in)
    view = view_of(room, pieces[seed % len(pieces)] if pieces else None)
    job = Job(action=action, target="Target", seed=1000 * seed, variants=takes)
    if action in ("walk", "run"):
        # The other corner of the room, seen from the start.
        place = -room.start * [0.9, 0.0, 0.9]
        job = replace(job, target="", to=(0.0, 0.0, 0.0))
        view = replace(view, target=None, parts=(), destination=(place, None))
    return job, view
