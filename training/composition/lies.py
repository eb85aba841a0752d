"""Sequences of lying down on beds and sofas: a walk, a captured sit on the edge, swing and recline (recline.py)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...samp_addon import rotation
from ...samp_addon.motion import Goal
from ...samp_addon.scene.seats.postures import BED_TO_PELVIS, SEAT_TO_PELVIS
from ..mocap.augment import paced, relocked
from ..mocap.clip_files import Clip
from ..mocap.events import SitEvent, headings
from .checks import fault
from .recline import Recline, laid, softened, swing
from .sequence import Sequence
from .sits import Furnishing, collides, lifted, of_one_height, placement, sunk
from .walks import by_way_point, way_points

DEEPEST = 0.75  # largest distance (m) from the lying pelvis to the edge, the limit of scooting
BEHIND_EDGE = (0.03, 0.14)  # metres from the edge back to the pelvis seated on it
SEATED = (6, 20)  # frames on the edge before the swing
SWING = (26, 44)  # frames of the swing
MAX_PLACES = 8  # places tried for one motion
PACES = (1.0, 1.6)
MOST_LIFT = 0.15
STRIP = 0.22  # half width (m) of the strip around the seat on the edge that must be free


@dataclass(frozen=True)
class Edge:
    """An edge to sit down on beside a place to lie.

    goal: lying goal in the piece's frame. out: (3,) unit direction outwards over the edge. distance: metres from the
    lying pelvis to the edge.
    """

    goal: Goal
    out: np.ndarray
    distance: float

    @property
    def mattress(self) -> float:
        """Height of the mattress, metres."""
        return float(self.goal.position[1]) - BED_TO_PELVIS


def edges(piece: Furnishing) -> list[Edge]:
    """Return the free edges beside the lying places of a piece."""
    found = []
    for goal in piece.goals:
        along = np.asarray(goal.direction)
        for out in (np.array([along[2], 0.0, -along[0]]), np.array([-along[2], 0.0, along[0]])):
            distance = _edge_distance(piece.surface, goal, out)
            if distance is not None:
                found.append(Edge(goal, out, distance))
    return found


def _edge_distance(surface: np.ndarray, goal: Goal, out: np.ndarray) -> float | None:
    """Return the distance, metres, from a lying pelvis to the edge on one side; None where blocked or too far."""
    away = surface - goal.position
    beside = away @ out
    strip = np.abs(away @ np.asarray(goal.direction)) < STRIP
    height = away[:, 1] + BED_TO_PELVIS  # over the mattress
    level = strip & (np.abs(height) < 0.08) & (beside > 0)
    if level.sum() < 10:
        return None
    distance = float(np.percentile(beside[level], 99))
    # A few points may belong to a pillow or a blanket.
    blocked = strip & (height > 0.15) & (beside > 0.1) & (beside < distance + 0.3)
    beyond = strip & (beside > distance + 0.06) & (beside < distance + 0.5)
    if not 0.12 < distance < DEEPEST or blocked.sum() > 6 or beyond.sum() > 6:
        return None
    return distance


class LieComposer:
    """Compose sequences of lying down from sits, reclines and pieces; report counts kept and dropped ones by reason."""

    def __init__(
        self,
        pieces: list[Furnishing],
        events: list[SitEvent],
        reclines: list[Recline],
        approach: Callable[[Clip, dict[str, int]], tuple[Clip, dict[str, int]]],
        seed: int,
        surface_check: bool = True,
    ) -> None:
        """Collect the edges of the pieces.

        approach: prepends a captured walk to an excerpt, see Composer.approach. surface_check: whether bodies that are
        too deep in the surface are dropped; for lies that are not fitted afterwards.
        """
        self.surface_check = surface_check
        self.rng = np.random.default_rng(seed)
        self.report: Counter[str] = Counter()
        self.places = [(piece, edge) for piece in pieces for edge in edges(piece)]
        self.events, self.reclines, self.approach = events, reclines, approach
        self.mattresses = np.array([edge.mattress for _, edge in self.places])
        self.heights = np.array([event.pelvis[1] for event in events])

    def compose(self) -> Sequence | None:
        """Return a sequence on the first of some places of a random height whose path is free, or None."""
        candidates = self._places_of_one_height()
        seat = candidates[0][1].mattress + SEAT_TO_PELVIS
        fits = np.flatnonzero(np.abs(self.heights - seat) < MOST_LIFT)
        if not len(fits):
            return self._dropped("no sit of that height")
        event = self.events[self.rng.choice(fits)]
        clip, frames = self._seated(event, seat)
        found = self._free_place(candidates, clip, frames)
        if found is None:
            return self._dropped("no way to it is free")
        piece, edge, place, goal = found
        down, still = self._lying(clip, frames, edge, goal, place)
        up = self.rng.random() < 0.4 and event.up_end > event.seat_end
        whole = self._joined(clip, frames, down, up)
        frames = {**frames, "still": frames["seated"] + 1 + still}
        near = np.zeros(len(whole), bool)
        near[frames["down"] : -(len(clip) - frames["up_end"]) if up else None] = True
        why = collides(whole, piece, place, near)
        if why in ("walks into it", "stands in it"):
            return self._dropped(why)
        lying = whole.cut(frames["seated"] + len(down) // 3, frames["seated"] + len(down))
        why = fault(whole) or (self.surface_check and sunk(lying, piece, place, edge.mattress)) or None
        if why is not None:
            return self._dropped(why)
        self.report["kept"] += 1
        return self._sequence(whole, frames, piece.index, place, goal, len(down) if up else None)

    def _places_of_one_height(self) -> list[tuple[Furnishing, Edge]]:
        """Return a random place, and others within two centimetres of its height."""
        first = self.rng.integers(len(self.places))
        return [self.places[k] for k in of_one_height(self.mattresses, first, MAX_PLACES, self.rng)]

    def _free_place(
        self, places: list[tuple[Furnishing, Edge]], clip: Clip, frames: dict[str, int]
    ) -> tuple[Furnishing, Edge, tuple[float, float, float], Goal] | None:
        """Return the first place whose piece does not block the path: piece, edge, placement, lying goal."""
        way = clip.cut(0, frames["seated"] + 1)
        sits = np.arange(len(way)) >= frames["down"]
        for piece, edge in places:
            place, goal = self._place(edge, clip, frames)
            if collides(way, piece, place, sits) not in ("walks into it", "stands in it"):
                return piece, edge, place, goal
        return None

    def _dropped(self, why: str) -> None:
        self.report[why] += 1

    def _seated(self, event: SitEvent, seat: float) -> tuple[Clip, dict[str, int]]:
        """Return the event's approach, sitting down and standing up, raised to the mattress, and its key frames."""
        last = event.leave_end if event.up_end > event.seat_end else event.seat_end
        clip = event.clip.cut(event.entry, last + 1)
        frames = {
            name: getattr(event, name) - event.entry for name in ("down", "seated", "seat_end", "up_end")
        }
        clip = relocked(lifted(clip, event.pelvis[1], seat - event.pelvis[1]))
        if self.rng.random() < 0.75 and frames["down"] > 12:
            clip, frames = self.approach(clip, frames)
        # The swing begins some frames after sitting down, independent of the captured sit's length.
        frames["leave"] = frames["seat_end"]
        frames["seated"] = min(frames["seated"] + int(self.rng.integers(*SEATED)), frames["seat_end"])
        return clip, frames

    def _place(
        self, edge: Edge, clip: Clip, frames: dict[str, int]
    ) -> tuple[tuple[float, float, float], Goal]:
        """Return the placement of the piece in the world, and the lying goal there."""
        behind = min(self.rng.uniform(*BEHIND_EDGE), edge.distance - 0.02)
        along = np.asarray(edge.goal.direction)
        seat = edge.goal.position + (edge.distance - behind) * edge.out + self.rng.uniform(-0.1, 0.15) * along
        yaw = headings(clip.root[frames["seated"]][None], clip.rotations[frames["seated"]][None])[0]
        place = placement(Goal(seat, edge.out), clip.root[frames["seated"]], yaw)
        turn = rotation.about_y(place[2])
        goal = Goal(
            rotation.rotate(turn, edge.goal.position) + np.array([place[0], 0.0, place[1]]),
            rotation.rotate(turn, along),
            "lie",
        )
        return place, goal

    def _lying(
        self, clip: Clip, frames: dict[str, int], edge: Edge, goal: Goal, place: tuple[float, float, float]
    ) -> tuple[Clip, int]:
        """Return the swing with the recline, and the index of the first frame of lying still."""
        recline = _paced(self.reclines[self.rng.integers(len(self.reclines))], self.rng.uniform(*PACES))
        lying = laid(recline, goal.position, float(np.arctan2(goal.direction[0], goal.direction[2])))
        out = rotation.rotate(rotation.about_y(place[2]), edge.out)
        seated = clip.cut(0, frames["seated"] + 1)
        between = swing(
            seated, lying, int(self.rng.integers(*SWING)), edge.mattress, (goal.position, out, edge.distance)
        )
        keep = recline.still + int(self.rng.integers(20, 70))
        down = _cat([between, lying.cut(0, min(keep, len(lying)))])
        labels = np.array(["lie_down"] * len(down), dtype=object)
        labels[len(between) + recline.still :] = "lie"
        return replace(down, labels=labels.astype(str)), len(between) + recline.still

    def _joined(self, clip: Clip, frames: dict[str, int], down: Clip, up: bool) -> Clip:
        """Return approach, seat on the edge, lying down, and optionally getting up again."""
        first = clip.cut(0, frames["seated"] + 1)
        labels = first.labels.astype(object)
        labels[frames["down"] :] = "lie_down"
        parts = [replace(first, labels=labels.astype(str)), down]
        joins = [len(first)]
        if up:
            back = replace(
                down,
                root=down.root[::-1],
                rotations=down.rotations[::-1],
                labels=np.array(["get_up"] * len(down)),
            )
            after = clip.cut(frames["leave"], len(clip))
            joins.append(len(first) + 2 * len(down))
            parts += [back, self._continued(clip, frames, after)]
        whole = _cat(parts)
        return softened(replace(whole, rotations=rotation.continuous(whole.rotations)), joins)

    def _continued(self, clip: Clip, frames: dict[str, int], after: Clip) -> Clip:
        """Return the captured standing up, blended in from the pose in which the swing began."""
        fade = np.linspace(1, 0, 16)[:, None] ** 2
        n = min(len(after), 16)
        root, rotations = after.root.copy(), after.rotations.copy()
        at = frames["seated"]
        root[:n] += fade[:n] * (clip.root[at] - after.root[0])
        same = np.where((clip.rotations[at] * after.rotations[0]).sum(-1, keepdims=True) < 0, -1.0, 1.0)
        rotations[:n] = rotation.normalise(
            rotations[:n] + fade[:n, None] * (clip.rotations[at] * same - after.rotations[0])
        )
        return replace(after, root=root, rotations=rotations)

    def _sequence(
        self, clip: Clip, frames: dict[str, int], piece: int, place: tuple[float, float, float], lying: Goal,
        length: int | None,
    ) -> Sequence:  # fmt: skip
        """Return the sequence with its goals: optionally a way-point, the lie, then way-points after getting up."""
        count = len(clip)
        yaw = headings(clip.root, clip.rotations)
        goal, action = np.tile([*lying.position, *lying.direction], (count, 1)), np.full(count, 4)
        by_way_point(goal, action, clip.root, yaw, frames["down"], self.rng)
        if length is not None:
            leave = frames["seated"] + 1 + length - int(self.rng.integers(0, 10))
            goal[leave:], action[leave:] = way_points(clip.root, yaw, clip.labels, leave, count, self.rng)
        return Sequence(
            "lie", clip.root, clip.rotations, clip.labels, clip.feet, clip.bad, goal, action, piece, place,
            open_start=True, open_end=length is not None and clip.labels[-1] in ("walk", "run"),
        )  # fmt: skip


def _paced(recline: Recline, factor: float) -> Recline:
    clip = paced(recline.clip, factor)
    return Recline(clip, min(round(recline.still / factor), len(clip) - 2))


def _cat(parts: list[Clip]) -> Clip:
    whole = {name: np.concatenate([getattr(part, name) for part in parts])
             for name in ("root", "rotations", "labels", "feet", "bad")}  # fmt: skip
    return replace(parts[0], **whole)
