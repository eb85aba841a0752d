"""Measure how well the sits of a fitted training set fit their furniture; print the table of docs/training.md.

python -m samp_blender.training.fitting.measure --data fitted.npz --furniture FOLDER [--most 80]
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...samp_addon import rotation
from ...samp_addon.evaluation import feet, metrics
from ...samp_addon.motion import Motion
from . import hold as holds
from .lying import lie_fit
from .shapes import pieces as furnishing
from .shapes import posing, probes
from .shapes.kept import kept
from .shapes.pieces import FittingPiece
from .shapes.surfaces import Frame, SeatSurface
from .sit_fit import DEEPEST

LEANT = 0.03  # gap (m) between back and rest within which a body leans
TOUCHING = 0.01  # gap (m) within which a seat is touched
AT_REST = 0.04  # distance (m) from the goal within which a pelvis is at rest
PARTS = {
    "trunk": lie_fit.TRUNK,
    "head": ("head",),
    "feet": ("left_ankle", "right_ankle", "left_foot", "right_foot"),
}


@dataclass(frozen=True)
class Taken:
    """One sequence of the set.

    root: (T, 3) metres. rotations: (T, 22, 4). pelvis: (T,), hands: (T, 2) contacts. goal: (T, 6). goal_action: (T,).
    """

    kind: str
    piece: int
    placement: np.ndarray
    root: np.ndarray
    rotations: np.ndarray
    pelvis: np.ndarray
    hands: np.ndarray
    goal: np.ndarray
    goal_action: np.ndarray


def sequences(path: Path) -> list[Taken]:
    """Read all sequences of a training set."""
    with np.load(path) as data:
        raw = {name: data[name] for name in data.files}
    bounds = np.concatenate([[0], np.cumsum(raw["lengths"])])
    return [
        Taken(
            str(raw["kinds"][k]), int(raw["pieces"][k]), raw["placements"][k].astype(float),
            raw["root"][a:b].astype(float), rotation.normalise(raw["rotations"][a:b] / 32767.0),
            raw["contacts"][a:b, 0].astype(float), raw["contacts"][a:b, 1:3].astype(float),
            raw["goal"][a:b].astype(float), raw["goal_action"][a:b],
        )
        for k, (a, b) in enumerate(zip(bounds[:-1], bounds[1:], strict=True))
    ]  # fmt: skip


def surface_under(taken: Taken, piece: FittingPiece) -> SeatSurface:
    """Return the surface of the seat of a fitted sit; the sequence's world is that seat's frame."""
    turn = -taken.placement[2]
    to_piece = rotation.quaternion_to_matrix(rotation.about_y(turn))
    origin = -to_piece @ [taken.placement[0], 0.0, taken.placement[1]]
    nearest = min(piece.seats, key=lambda goal: np.hypot(*(goal.position - origin)[[0, 2]]))
    direction = np.array([np.sin(turn), 0.0, np.cos(turn)])
    surface = piece.seat_surface(replace(nearest, direction=direction))
    if np.abs(Frame.of(nearest).origin - origin).max() > 0.02:
        raise ValueError("the sequence's world is not the frame of a seat of its piece")
    return surface


def measured(taken: Taken, piece: FittingPiece) -> dict[str, float]:
    """Return the measures of one sit or lie, in metres, degrees, seconds."""
    at, turned = in_piece(taken)
    low, high = piece.triangles.min((0, 1)), piece.triangles.max((0, 1))
    rows = np.flatnonzero(((at > low - 0.8) & (at < high + 0.8))[:, [0, 2]].all(1))[::2]
    deep, _ = piece.field.deepest(at[rows], turned[rows])
    motion = Motion(taken.root, taken.rotations)
    found = {
        "deepest": float(deep.max()),
        "frames deeper": float((deep > DEEPEST + piece.give).mean()),
        "jerk": metrics.jerk(motion),
        "stance slide": feet.measures(motion)["stance_slide_cm_s"] or np.nan,
        "give": piece.give,
    }
    return found | (seated(taken, piece) if taken.kind == "sit" else lying(taken, piece))


def in_piece(taken: Taken) -> tuple[np.ndarray, np.ndarray]:
    """Return root (T, 3) and rotations (T, 22, 4) in the frame of the sequence's piece."""
    x, z, yaw = taken.placement
    turn = rotation.about_y(-yaw)
    rotations = taken.rotations.copy()
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    return (taken.root - [x, 0.0, z]) @ rotation.quaternion_to_matrix(turn).T, rotations


def held(taken: Taken, action: int) -> np.ndarray:
    """Return every third of the frames in which the pelvis rests on its goal."""
    rests = np.flatnonzero(taken.pelvis > 0.9)
    goal = taken.goal[taken.goal_action == action][-1, :3]
    return rests[np.linalg.norm(taken.root[rests] - goal, axis=-1) < AT_REST][::3]


def seated(taken: Taken, piece: FittingPiece) -> dict[str, float]:
    """Return contacts and posture in the hold of a sit."""
    hold = held(taken, 3)
    if not len(hold):
        return {}
    surface = surface_under(taken, piece)
    root, turns = taken.root[hold], taken.rotations[hold]
    contact, nearest = holds.seat_gap(root, turns, surface)
    ahead = np.array([0.0, 0.0, 1.0])
    return {
        "seat contact": float((nearest < TOUCHING).mean()),
        "seat gap": float(np.median(contact)),
        "pelvis over seat": float(np.median(root[:, 1]) - surface.level),
        "back gap": float(np.median(holds.back_gap(root, turns, surface))) if surface.backed else np.nan,
        "lean": float(np.degrees(np.median(posing.trunk_lean(root, turns, ahead)))),
        "knee": float(np.median(posing.knees(root, turns))),
        "hand on furniture": float(taken.hands[hold].max(1).mean()),
    }


def lying(taken: Taken, piece: FittingPiece) -> dict[str, float]:
    """Return contacts in the hold of a lie: distances of trunk, head and feet from their support, metres."""
    hold = held(taken, 4)
    if not len(hold):
        return {}
    root, turns = (part[hold] for part in in_piece(taken))
    found = {"knee": float(np.median(posing.knees(root, turns)))}
    for name, joints in PARTS.items():
        skin = probes.skinned(root, turns, probes.named(*joints))
        found[f"{name} gap"] = float(np.median(np.sort(piece.field.distance(skin), 1)[:, :6].mean(1)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--furniture", type=Path)
    parser.add_argument("--kind", choices=("sit", "lie"), default="sit")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--most", type=int, default=80, help="number of randomly drawn sits to measure")
    parser.add_argument("--kept", type=Path, help="as in fitting.make")
    options = parser.parse_args()
    pieces = kept(options.kept, "pieces", lambda: furnishing.collect(options.furniture, options.seed))
    sits = [s for s in sequences(options.data) if s.kind == options.kind]
    chosen = np.random.default_rng(options.seed).permutation(len(sits))[: options.most]
    columns: dict[str, list[float]] = defaultdict(list)
    for k in chosen:
        for name, value in measured(sits[k], pieces[sits[k].piece]).items():
            columns[name].append(value)
    for name, values in columns.items():
        finite = np.array(values)
        finite = finite[np.isfinite(finite)]
        low, middle, high = np.percentile(finite, [10, 50, 90])
        print(f"{name:20s} {len(finite):4d}  median {middle:.3f}  10 % {low:.3f}  90 % {high:.3f}")
    deeper = np.array(columns["frames deeper"]) > 0
    gaps = np.array(columns["back gap"] or [np.nan])
    gaps = gaps[np.isfinite(gaps)]
    print(f"{options.kind}s with a frame deeper than 2 cm: {deeper.mean():.3f} of {len(deeper)}")
    if len(gaps):
        print(f"back within 3 cm of its rest: {(gaps < LEANT).mean():.3f} of {len(gaps)} on backed pieces")


if __name__ == "__main__":
    main()
