"""Takes on furniture that no training has seen, by the papers' measures: make evaluate

python -m samp_blender.training.evaluate [--rooms 12] [--takes 3] [--furniture FOLDER] [--mocap FOLDER]
    [--weights FOLDER] [--network motion_net | mlp | moe]

The rooms have five obstacles and a start behind one of them. Their seats are the held-out real pieces where the
furniture is there, and boxes otherwise; real motion beside which feet and jerk are judged needs the test clips.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from ..samp_addon.errors import SampError
from ..samp_addon.evaluation import diversity, feet, metrics
from ..samp_addon.job import Job
from ..samp_addon.motion import Goal, Motion
from ..samp_addon.scene.geometry import SceneGeometry
from ..samp_addon.synthesis import goals, samp
from ..samp_addon.synthesis.chain import Situation, Take, Tools, synthesise
from ..tests import rooms
from . import furniture, mocap, tables
from .look import load_motion
from .motion.events import sit_events

SHARED = Path(__file__).resolve().parent.parent.parent / "shared" / "data"
SEATS = {"sit": ("armchair", "chair", "sofa", "stool", "bench"), "lie": ("bed", "sofa")}
MEDIANS = (
    ("position_error_cm", "PE, cm"),
    ("rotation_error_deg", "RE, deg"),
    ("execution_time_s", "execution time, s"),
    ("penetration_2cm_percent", "frames deeper than 2 cm, %"),
    ("penetration_5cm_percent", "frames deeper than 5 cm, %"),
    ("penetration_max_cm", "deepest, cm"),
    ("non_collision", "non-collision"),
    ("contact", "contact"),
    ("foot_slide_cm_s", "foot slide, cm/s"),
    ("stance_slide_cm_s", "stance slide, cm/s"),
    ("stance_share", "share of time in stance"),
    ("jerk_m_s3", "jerk, m/s^3"),
)


@dataclass
class Results:
    """All takes of an action with their measures, and how many seeds failed."""

    takes: list[Take]
    numbers: list[dict]
    alike: list[list[Motion]]
    failed: int = 0


def held_out_seats(folder: Path, action: str = "sit") -> list[furniture.piece.Piece]:
    """The real pieces to sit or lie on that no training has seen; none where the folder is missing."""
    try:
        pieces = furniture.library.load(folder, held_out=True)
    except FileNotFoundError:
        return []
    return [piece for piece in pieces if piece.category in SEATS.get(action, ())]


def situation(room: rooms.Room, piece: furniture.piece.Piece | None) -> Situation:
    """A room with a real piece in place of its seat, if there is one."""
    target = room.target.triangles
    if piece is not None:
        turned = rooms.turned(piece.triangles, room.target.yaw)
        target = turned + [room.target.at[0], 0.0, room.target.at[1]]
    others = [(obstacle.name, obstacle.triangles) for obstacle in room.pieces[1:]]
    scene = SceneGeometry.from_objects([("Floor", room.floor), ("Target", target), *others])
    return Situation(scene, target, ("Target",), (room.start, room.start_yaw))


def evaluate(action: str, count: int, takes: int, pieces: Sequence, tools: Tools | None = None) -> Results:
    """Takes of one action in `count` rooms."""
    results = Results([], [], [])
    for seed in range(count):
        stand_in = rooms.bed if action == "lie" else rooms.sofa if pieces else None
        room = rooms.random_room(1000 + seed, stand_in)
        told = situation(room, pieces[seed % len(pieces)] if pieces else None)
        job = Job(action=action, target="Target", seed=1000 * seed, variants=takes)
        if action in ("walk", "run"):
            # The other corner of the room, seen from the start.
            place = -room.start * [0.9, 0.0, 0.9]
            job = replace(job, target="", to=(0.0, 0.0, 0.0))
            told = replace(told, target=None, parts=(), destination=(place, None))
        try:
            made, failures = synthesise(job, told, tools=tools)
        except SampError as error:
            print(f"room {seed}: {error}", file=sys.stderr)
            results.failed += takes
            continue
        for failure in failures:
            print(f"room {seed}, seed {failure.seed}: {failure.message}", file=sys.stderr)
        results.failed += len(failures)
        results.takes += made
        results.numbers += [
            metrics.measure(take.motion, take.goal, told.scene.triangles, float(take.waypoints[:, 1].min()))
            | {"attempts": take.attempts}
            for take in made
        ]
        if len(made) > 1:
            results.alike.append([take.motion for take in made])
    return results


def real_motion(folder: Path, action: str) -> list[Motion]:
    """Test clips of an action, by the labels; none where the folder is missing."""
    names = {"sit": ("sit", "sit_down"), "walk": ("walk",), "run": ("run",), "lie": ("lie", "lie_down")}[
        action
    ]
    found = []
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as data:
            labels = data["label_names"][data["label"]]
        if np.isin(labels, names).mean() > 0.3:
            found.append(load_motion(path))
    return found


def real_pace(folders: Sequence[Path]) -> tuple[float, float] | None:
    """Seconds and seconds a metre that real people need to walk to a seat and sit still on it: a straight line through
    all captured sits of some folders; None where there are fewer than ten."""
    ways, times = [], []
    for clip in (clip for folder in folders if folder.exists() for clip in mocap.load_clips(folder)):
        for event in sit_events(clip):
            part = clip.cut(event.entry, event.seat_end + 1)
            goal = Goal(event.pelvis, np.array([np.sin(event.yaw), 0.0, np.cos(event.yaw)]))
            needed = metrics.execution_time(Motion(part.root, part.rotations), goal)
            if needed is not None:
                before = part.root[: round(needed * mocap.FPS) + 1, [0, 2]]
                ways.append(np.linalg.norm(np.diff(before, axis=0), axis=-1).sum())
                times.append(needed)
    if len(ways) < 10:
        return None
    slope, start = np.polyfit(ways, times, 1)
    return float(start), float(slope)


def execution_ratios(results: Results, pace: tuple[float, float]) -> list[float]:
    """The takes' execution times over those of real people on ways of the same length."""
    ratios = []
    for take, numbers in zip(results.takes, results.numbers, strict=True):
        way = float(np.linalg.norm(np.diff(take.waypoints[:, [0, 2]], axis=0), axis=-1).sum())
        if numbers["execution_time_s"] is not None:
            ratios.append(numbers["execution_time_s"] / (pace[0] + pace[1] * way))
    return ratios


def table(
    action: str, results: Results, real: Sequence[Motion], pace: tuple[float, float] | None = None
) -> str:
    """The measures of an action as a table in Markdown. pace: of real people, see real_pace."""
    asked = len(results.takes) + results.failed
    lines = [f"{action}: {len(results.takes)} takes of {asked} asked for"]
    if not results.takes:
        return lines[0]
    won = sum(bool(numbers["success"]) for numbers in results.numbers)
    low, high = tables.share(won, asked)
    first = sum(numbers["attempts"] == 1 and bool(numbers["success"]) for numbers in results.numbers)
    lines += ["", tables.HEADER]
    lines.append(tables.row(action, "success", "success", f"{won} of {asked} ({low:.0%} to {high:.0%})"))
    lines.append(tables.row(action, "first", "success at the first attempt", f"{first} of {asked}"))
    reference = _reference(real)
    for key, name in MEDIANS:
        values = [numbers[key] for numbers in results.numbers if numbers.get(key) is not None]
        if values:
            lines.append(tables.row(action, key, name, str(tables.Estimate.of(values)), reference.get(key)))
    if pace is not None and (ratios := execution_ratios(results, pace)):
        told = str(tables.Estimate.of(ratios))
        lines.append(tables.row(action, "execution_ratio", "execution time over real", told))
    if results.alike:
        apd = tables.Estimate.of([diversity.diversity(motions) for motions in results.alike])
        own = diversity.diversity(real) if len(real) > 1 else None
        lines.append(tables.row(action, "APD", "APD", str(apd), own))
    if real:
        distance = diversity.motion_distance([take.motion for take in results.takes], real)
        lines.append(tables.row(action, "FD", "FD", f"{distance:.2f}"))
    return "\n".join(lines)


def _reference(real: Sequence[Motion]) -> dict[str, float]:
    """What real motion measures at the feet and in jerk, mean over clips."""
    told = [feet.measures(motion, 0.0) | {"jerk_m_s3": metrics.jerk(motion)} for motion in real]
    return {
        key: statistics.mean(values)
        for key in ("foot_slide_cm_s", "stance_slide_cm_s", "stance_share", "jerk_m_s3")
        if (values := [one[key] for one in told if one[key] is not None])
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the tables; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", type=int, default=12)
    parser.add_argument("--takes", type=int, default=3)
    parser.add_argument("--actions", nargs="+", default=["sit", "lie", "walk", "run"])
    parser.add_argument("--furniture", type=Path, default=SHARED / "furniture")
    parser.add_argument("--mocap", type=Path, default=SHARED / "mocap" / "test")
    parser.add_argument(
        "--weights", type=Path, help="folder of motion_net.safetensors; left out, the shipped ones"
    )
    parser.add_argument("--network", default="motion_net", help="motion_net, mlp or moe")
    options = parser.parse_args(arguments)
    network = samp.load_network(options.weights, options.network)
    tools = Tools(goals.sample_goals, partial(samp.generate, network=network))
    pace = real_pace([options.mocap, options.mocap.parent / "smplx30"])
    for action in options.actions:
        pieces = held_out_seats(options.furniture, action)
        if action in SEATS:
            print(f"{action}: {len(pieces)} held-out pieces" if pieces else f"{action}: boxes")
        real = real_motion(options.mocap, action)
        print(
            table(
                action,
                evaluate(action, options.rooms, options.takes, pieces, tools),
                real,
                pace if action == "sit" else None,
            ),
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
