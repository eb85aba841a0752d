"""Uses read from a training set of fitted sits and lies (training/fitting/make.py) and its file of pieces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ....samp_addon import rotation, skeleton
from ...composition.sequence import Sequence
from ...fitting.shapes.piece_file import read_pieces
from ..classes import OF_CATEGORY, Part
from ..episodes.bank import Bank
from ..layout.stock import Item
from .use import Use, Uses, of_sequence, place_of, sound, with_rises

SAME_SIT = 0.003  # metres within which the goals of one sit with different approaches agree
# Fitting preserves the captured head and arms, unless a hand is on an armrest: both arms, left, right.
MATCHED = tuple(
    [skeleton.INDEX[f"{side}_{name}"] for side in sides for name in ("shoulder", "elbow", "wrist")]
    + [skeleton.INDEX["head"]]
    for sides in (("left", "right"), ("left",), ("right",))
)
ALIKE = (0.12, 0.09, 0.09)  # distances of MATCHED's quaternions below which a bank frame is the source
GAP = 120  # largest gap (frames) without a match that is interpolated
RISEN = 0.975  # share of the standing height at which standing up ends
FAST = 2.2  # largest number of captured frames per frame
SEATED_LABELS = ("sit", "lie")


class FittedSet:
    """Uses of files for their items, and those of ``others`` for all other items; see use.Uses."""

    def __init__(self, paths: list[Path], bank: Bank, others: Uses | None = None) -> None:
        """Read training sets; pieces of the same name have to be identical in all of them."""
        self.others = others
        self.items: dict[str, Item] = {}
        self._uses: dict[str, list[Use]] = {}
        sources = _Sources(bank)
        for path in paths:
            self._read(path, sources)
        self._uses = {name: with_rises(sound(uses, self.items[name])) for name, uses in self._uses.items()}

    def _read(self, path: Path, sources: _Sources) -> None:
        pieces = read_pieces(path)
        for piece in pieces:
            self.items.setdefault(piece.name, _item(piece.name, piece.category, piece.triangles))
            self._uses.setdefault(piece.name, [])
        for sequence in sits_and_lies(path):
            uses = self._uses[pieces[sequence.piece].name]
            use = of_sequence(sequence, 0, sources.of(sequence.rotations), fitted=True)
            uses.append(replace(use, place=place_of(uses, use)))

    def of(self, item: Item) -> list[Use]:
        """Return all uses of an item; see use.Uses."""
        mine = self._uses.get(item.name)
        return mine if mine is not None else self.others.of(item) if self.others is not None else []

    def used_items(self) -> list[Item]:
        """Return the items with at least one use."""
        return [self.items[name] for name, uses in self._uses.items() if uses]


def _item(name: str, category: str, triangles: np.ndarray) -> Item:
    item = Item(name, category, [Part(OF_CATEGORY[category], triangles.astype(np.float64))])
    return Item(name, "bar_stool", item.parts) if category == "stool" and item.size[1] > 0.7 else item


def sits_and_lies(path: Path) -> list[Sequence]:
    """Read the sequences with labels; of a sit with several approaches only the first, its own."""
    with np.load(path) as file:
        data = {name: file[name] for name in file.files if not name.startswith("piece_")}
    ends = np.cumsum(data["lengths"])
    made: list[Sequence] = []
    seen: dict[tuple[str, int], list[np.ndarray]] = {}
    for k, (stop, length) in enumerate(zip(ends, data["lengths"], strict=True)):
        part = slice(stop - length, stop)
        kind, piece = str(data["kinds"][k]), int(data["pieces"][k])
        if kind not in ("sit", "lie"):
            continue
        goal, action = data["goal"][part], data["goal_action"][part]
        # Goals in the piece's frame are equal for all approaches of a sit, whose sequences differ in their frames.
        x, z, yaw = (float(v) for v in data["placements"][k])
        at = goal[np.flatnonzero(action >= 3)[0], :3] - [x, 0.0, z]
        local = rotation.rotate(rotation.about_y(-yaw), at)
        known = seen.setdefault((kind, piece), [])
        if any(np.linalg.norm(local - other) < SAME_SIT for other in known):
            continue
        labels = labelled(data["actions"][part], data["contacts"][part, 0] > 0.5, data["root"][part, 1])
        if not np.isin(labels, SEATED_LABELS).any():
            continue
        known.append(local)
        made.append(Sequence(
            kind, data["root"][part].astype(np.float64),
            rotation.normalise(data["rotations"][part].astype(np.float64)), labels,
            data["contacts"][part][:, 3:5].astype(np.float64), data["bad"][part], goal.astype(np.float64),
            action.astype(int), piece, (x, z, yaw), hands=data["contacts"][part][:, 1:3].astype(np.float64),
        ))  # fmt: skip
    return made


def labelled(actions: np.ndarray, rests: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return labels (T,) from action weights (T, 5), pelvis contacts (T,) and pelvis heights (T,), metres."""
    action = actions.astype(np.float32).argmax(1)
    labels = np.array(["idle", "walk", "run", "sit_down", "lie_down"])[action]
    on = np.flatnonzero(rests)
    if not len(on):
        return labels
    labels = labels.astype("<U8")
    labels[rests] = np.where(action[rests] == 4, "lie", "sit")
    frames, standing = np.arange(len(labels)), np.percentile(height, 95)
    if (labels == "lie").any():
        last = int(np.flatnonzero(labels == "lie")[-1])
        later = on[on > last]
        stop = int(later[0]) if len(later) else len(labels)
        up = (frames > last) & (frames < stop) & (height < RISEN * standing)
        labels[up] = "get_up"
    low = (frames > on[-1]) & (height < RISEN * standing) & (labels != "get_up")
    # Standing up is the run of low frames directly after the seat, regardless of the smoothed actions.
    stop = on[-1] + 1 + int(np.argmin(np.append(low[on[-1] + 1 :], False)))
    labels[on[-1] + 1 : stop] = np.where(labels[on[-1] + 1 : stop] == "get_up", "get_up", "stand_up")
    rest = labels[stop:]
    rest[np.isin(rest, ("sit_down", "lie_down"))] = "idle"
    # Smoothed weights may shift the start of sitting down by a few frames, but it has no gap before the seat.
    first = int(on[0])
    going = np.flatnonzero(np.isin(labels[:first], ("sit_down", "lie_down")))
    if len(going):
        labels[going[0] : first] = labels[going[0]]
    return labels


@dataclass
class _Sources:
    """Search for the bank frames of motion whose head and at least one arm are as captured."""

    bank: Bank

    def __post_init__(self) -> None:
        self.trees = [
            cKDTree(_vectors(self.bank.rotations, joints), balanced_tree=False, compact_nodes=False)
            for joints in MATCHED
        ]

    def of(self, rotations: np.ndarray) -> np.ndarray:
        """Return the bank frames (T,) of rotations (T, 22, 4), -1 where there is none."""
        best = np.full(len(rotations), -1)
        for joints, alike, tree in zip(MATCHED, ALIKE, self.trees, strict=True):
            _, found = tree.query(_vectors(rotations, joints), distance_upper_bound=alike)
            steady = _steady(np.where(found < tree.n, found, -1), self.bank.clip)
            if (steady >= 0).sum() > (best >= 0).sum():
                best = steady
        return best


def _vectors(rotations: np.ndarray, joints: list[int]) -> np.ndarray:
    part = rotations[:, joints].astype(np.float32)
    part = part / np.linalg.norm(part, axis=-1, keepdims=True)
    return np.where(part[..., :1] < 0, -part, part).reshape(len(part), -1)


def _steady(found: np.ndarray, clip: np.ndarray) -> np.ndarray:
    """Fill gaps between matches in one clip, in order and at a plausible pace."""
    out = found.copy()
    some = np.flatnonzero(found >= 0)
    for a, b in zip(some[:-1], some[1:], strict=True):
        ahead = found[b] - found[a]
        if 1 < b - a < GAP and clip[found[a]] == clip[found[b]] and 0 <= ahead <= FAST * (b - a):
            out[a : b + 1] = np.round(np.linspace(found[a], found[b], b - a + 1)).astype(found.dtype)
    return out
