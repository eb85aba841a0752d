"""Export a corpus as a training set of MotionNet (training/composition/sequence.py): sits, lies and walks in rooms.

python -m samp_blender.training.rooms.corpus.export --output cache/rooms --to motion.npz --frames 600000

Goals of sits and lies are at the resting pelvis; the voxel grid of each is centred on its goal and shows the piece in
use. Motions are retargeted to the default human, whose proportions MotionNet learns.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ....samp_addon import frames
from ....samp_addon.evaluation import rest_posture
from ....samp_addon.motion import Motion
from ....samp_addon.refine.feet.foot_lock import CAPTURED, lock_feet
from ....samp_addon.scene.voxels import InteractionGrid
from ...composition.sequence import Sequence, save
from ...composition.walks import by_way_point, way_points
from ...mocap.events import headings
from ..episodes import bodies
from ..episodes.bank import LABELS
from ..layout.room import Room
from . import store

APPROACH, LEAVE = 150, 90  # largest number of frames before sitting down and after standing up in a sit
SHORTEST = 96  # frames of the shortest sequence, enough for a rollout and its start
NAMES = np.array(LABELS)
GOING, RESTING = ("sit_down", "lie_down"), ("sit", "lie")
ACTIONS = {"sit": 3, "lie": 4}


@dataclass
class Grids:
    """Voxel grids of the furniture around each goal."""

    centres: list[np.ndarray] = field(default_factory=list)
    occupancy: list[np.ndarray] = field(default_factory=list)

    def add(self, room: Room, item: int, place: tuple[float, float, float]) -> int:
        """Add the grid of a room's item around a goal at (x, z, yaw), metres and radians; return its number."""
        x, z, yaw = place
        away = room.triangles[room.objects == item] - [x, 0.0, z]
        grid = InteractionGrid.around(away @ frames.yawed_axes(yaw), np.zeros(3), yaw=0.0)
        self.centres.append(grid.centres.astype(np.float32))
        self.occupancy.append(grid.occupancy.astype(np.float32))
        return len(self.centres) - 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Return centres (P, 512, 3), metres, and occupancy (P, 512)."""
        return {
            "centres": np.array(self.centres, np.float32).reshape(-1, 512, 3),
            "occupancy": np.array(self.occupancy, np.float32).reshape(-1, 512),
        }


@dataclass(frozen=True)
class Stretch:
    """Frames first .. stop - 1 of an episode. rest: first and last resting frame, None for a walk. item: in use."""

    first: int
    stop: int
    rest: tuple[int, int] | None = None
    item: int = -1


def stretches(labels: np.ndarray, items: np.ndarray) -> list[Stretch]:
    """Split an episode with labels (T,) and items in use (T,), -1 for none, into sits, lies and walks."""
    used = np.concatenate([[-1], items, [-1]])
    cuts = np.flatnonzero(np.diff(used))
    runs = [(int(a), int(b)) for a, b in zip(cuts[:-1], cuts[1:], strict=True) if items[a] >= 0]
    found, free = [], 0
    for k, (first, stop) in enumerate(runs):
        following = runs[k + 1][0] if k + 1 < len(runs) else len(labels)
        rests = np.flatnonzero(np.isin(labels[first:stop], RESTING)) + first
        start = max(first - APPROACH, free)
        end = min(stop + LEAVE, stop + (following - stop) // 2 if k + 1 < len(runs) else following)
        if start - free >= SHORTEST:
            found.append(Stretch(free, start))
        # Runs that begin at rest lack the descent, which is what training needs.
        if len(rests) and labels[first] in GOING and end - start >= SHORTEST:
            found.append(Stretch(start, end, (int(rests[0]), int(rests[-1])), int(items[first])))
        free = end
    if len(labels) - free >= SHORTEST:
        found.append(Stretch(free, len(labels)))
    return found


def sequences(data: store.RoomData, episode: int, grids: Grids, rng: np.random.Generator) -> list[Sequence]:
    """Return the sequences of an episode, on the default human."""
    first, last = (int(v) for v in data.bounds[episode : episode + 2])
    numbers = np.array(data.array("motion", "labels")[first:last])
    items = np.array(data.array("motion", "objects")[first:last])
    motion = data.motion(episode)
    root, rotations = bodies.on_default(motion.root, motion.rotations, numbers, data.build(episode))
    locked = lock_feet(Motion(root, rotations, contacts=motion.contacts), settings=CAPTURED)
    return [
        _sequence(data.room, part, locked, NAMES[numbers], motion.contacts, grids, rng)
        for part in stretches(NAMES[numbers], items)
    ]


def _sequence(
    room: Room, part: Stretch, motion: Motion, labels: np.ndarray, contacts: np.ndarray, grids: Grids,
    rng: np.random.Generator,
) -> Sequence:  # fmt: skip
    frames = slice(part.first, part.stop)
    root, rotations, labels, contacts = (
        motion.root[frames],
        motion.rotations[frames],
        labels[frames],
        contacts[frames],
    )
    count, yaw = len(root), headings(root, rotations)
    common = {"feet": contacts[:, 3:5], "bad": np.zeros(count, bool), "hands": contacts[:, 1:3]}
    if part.rest is None:
        goal, action = way_points(root, yaw, labels, 0, count, rng)
        kind = "walk" if (labels == "walk").mean() > 0.35 else "idle"
        return Sequence(kind, root, rotations, labels, goal=goal, goal_action=action, **common)
    seated, end = (frame - part.first for frame in part.rest)
    kind = "lie" if (labels == "lie").any() else "sit"
    still = np.flatnonzero(labels == kind)
    turn = yaw[still]
    facing = np.arctan2(np.sin(turn).mean(), np.cos(turn).mean())
    goal = np.tile([*np.median(root[still], axis=0), np.sin(facing), 0.0, np.cos(facing)], (count, 1))
    action = np.full(count, ACTIONS[kind])
    by_way_point(goal, action, root, yaw, int(np.argmax(np.isin(labels, GOING))), rng)
    if count > end + 20:
        leave = end - int(rng.integers(0, min(12, end - seated + 1)))
        goal[leave:], action[leave:] = way_points(root, yaw, labels, leave, count, rng)
    place = (float(goal[seated, 0]), float(goal[seated, 2]), float(facing))
    posture = rest_posture.shares(Motion(root, rotations), kind, still)
    return Sequence(
        kind, root, rotations, labels, goal=goal, goal_action=action, piece=grids.add(room, part.item, place),
        placement=place, posture=posture, **common,
    )  # fmt: skip


def export(corpus: store.Corpus, split: str, frames: int, seed: int) -> tuple[list[Sequence], Grids]:
    """Return sequences of random episodes of a split, at least ``frames`` frames, and the grids of their furniture."""
    rng = np.random.default_rng(seed)
    every = [
        (r["number"], e)
        for r in corpus.manifest["rooms"]
        if r["split"] == split
        for e in range(r["episodes"])
    ]
    made, grids, total = [], Grids(), 0
    for k in rng.permutation(len(every)):
        number, episode = every[k]
        made += sequences(corpus.room(number), episode, grids, rng)
        total = sum(len(s) for s in made)
        if total >= frames:
            break
    return made, grids


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    parser = argparse.ArgumentParser(prog="export", description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("cache/rooms"), help="folder of the corpus")
    parser.add_argument("--to", type=Path, required=True, help="training set to write, .npz")
    parser.add_argument("--split", choices=store.SPLITS, default="train")
    parser.add_argument("--frames", type=int, default=600_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    made, grids = export(store.Corpus(options.output), options.split, options.frames, options.seed)
    save(options.to, made, grids.arrays(), mirrored=True, goal_grid=True)
    kinds = sorted({s.kind for s in made})
    print(
        {
            kind: (sum(s.kind == kind for s in made), sum(len(s) for s in made if s.kind == kind))
            for kind in kinds
        }
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
