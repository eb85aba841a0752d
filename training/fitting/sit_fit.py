"""Fit one composed sit to one seat: position of the feet, depth of the pelvis, checks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..mocap.clip_files import Clip
from ..mocap.events import headings, turned
from . import hold as holds
from .hands import settled_hands
from .hold import Hold
from .shapes import posing, probes
from .shapes.depth import PieceField
from .shapes.surfaces import SeatSurface
from .spreading import Phases, spread

DEEPEST = 0.02  # largest mutual penetration of body and hard furniture, metres
MOST_BACK = 0.30  # metres by which a pelvis may move farther back than captured
STEP_BACK = 0.03
SHANK_CLEAR = 0.004  # largest penetration (m) of a shin before the final corrections
LEAST_BENT = 38.0  # least median knee flexion (degrees) in the hold, on seats that are not high
HIGH = 0.55  # height (m) of a seat from which legs may hang or be nearly straight
OFF_REST = 0.03  # gap (m) within which a back leans on its rest
STRIDE = 2  # stride of the checked frames
ON_THE_WAY = 4  # the same, on the walk to the seat and from it


@dataclass(frozen=True)
class Fitted:
    """A fitted sit.

    clip: in the seat frame. hold: the fitted seated pose. back: metres by which the pelvis moves farther back than
    captured. hands: (T, 2) contacts of right and left hand with the furniture.
    """

    clip: Clip
    hold: Hold
    back: float
    hands: np.ndarray


class Unfit(Exception):  # noqa: N818
    """The sit does not fit the seat; the message is the reason in a few words."""


def fit(
    clip: Clip, phases: Phases, surface: SeatSurface, field: PieceField, mode: str, rng: np.random.Generator
) -> Fitted:
    """Return the clip fitted to a seat in one of hold.MODES. Raise Unfit where it does not fit."""
    depth = holds.depth_of(surface, mode, field.give, rng)
    if depth is None:
        raise Unfit(f"no seat for {mode}")
    clip = facing(clip, phases)
    back = _room_for_shins(clip, phases, surface, field, depth)
    clip = replace(clip, root=clip.root + [0.0, 0.0, depth + back])
    free_way(clip, phases, surface, field)
    at = _reference(clip, phases, mode)
    places, feet = posing.ankles(clip.root[at : at + 1], clip.rotations[at : at + 1])
    root = clip.root[at] + [0.0, surface.level - seat_height(clip, at), 0.0]
    lean = float(
        posing.trunk_lean(clip.root[at : at + 1], clip.rotations[at : at + 1], np.array([0.0, 0.0, 1.0]))[0]
    )
    first = max(np.radians(rng.normal(12, 3)) - lean, 0.0) if mode == "leaning" else 0.0
    found = holds.solve(root, clip.rotations[at], (places, feet), surface, mode, depth, field.give, first)
    if mode == "leaning" and not abs(found.gap) < OFF_REST + field.give:
        raise Unfit("back does not reach the rest")
    if lean - found.pelvis - found.spine > holds.MOST_LEAN:
        raise Unfit("leans too far")
    made = spread(clip, phases, found, at, surface, field.give)
    bent = float(np.median(posing.knees(made.root[phases.hold], made.rotations[phases.hold])))
    if bent < LEAST_BENT and surface.level < HIGH:
        raise Unfit("legs stretched")
    made, hands = settled_hands(clip, made, phases, surface, field, rng)
    check(made, phases, surface, field)
    return Fitted(made, found, float(clip.root[at, 2] - found.depth), hands)


def seat_height(clip: Clip, at: int) -> float:
    """Return the height, metres, of the lowest skin under the pelvis in a seated frame."""
    seat = probes.skinned(clip.root[at : at + 1], clip.rotations[at : at + 1], probes.load().seat)[0]
    under = np.linalg.norm((seat - clip.root[at])[:, [0, 2]], axis=-1) < 0.16
    return float(seat[under, 1].min())


def facing(clip: Clip, phases: Phases) -> Clip:
    """Return the clip turned and moved so that the seated pelvis is over the origin and faces +Z."""
    yaw = headings(clip.root[phases.hold], clip.rotations[phases.hold])
    mean = np.arctan2(np.sin(yaw).mean(), np.cos(yaw).mean())
    root, rotations = turned(clip.root, clip.rotations, -mean, np.zeros(3))
    middle = np.median(root[phases.hold], axis=0)
    return replace(clip, root=root - middle * [1.0, 0.0, 1.0], rotations=rotations)


def _reference(clip: Clip, phases: Phases, mode: str) -> int:
    """Return the frame of the hold to fit: of median lean, or leaning back."""
    part = np.arange(len(clip))[phases.hold]
    lean = posing.trunk_lean(clip.root[part], clip.rotations[part], np.array([0.0, 0.0, 1.0]))
    return int(part[np.argmin(np.abs(lean - np.percentile(lean, 65 if mode == "leaning" else 50)))])


def _room_for_shins(
    clip: Clip, phases: Phases, surface: SeatSurface, field: PieceField, depth: float
) -> float:
    """Return the distance, metres, by which feet move forward from the pelvis to clear the shins. Raise Unfit."""
    standing = np.arange(max(phases.down - 12, 0), min(phases.down + 6, len(clip)))[::4]
    seated = np.concatenate(
        [[(phases.down + phases.seated) // 2], np.linspace(phases.seated, phases.up_end, 7)]
    )
    legs = probes.named("left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle")[::2]
    parts = []
    for rows, part in ((standing, legs), (seated.astype(int), probes.load().shanks[::2])):
        skin = probes.skinned(clip.root[rows], clip.rotations[rows], part)
        # Knees and calves of a seated body rise with the seat and are not counted.
        counted = part is legs or skin[..., 1] < min(surface.level - 0.04, 0.36)
        parts.append((skin, np.broadcast_to(counted, skin.shape[:2])))
    for back in np.arange(-0.02, MOST_BACK + 1e-6, STEP_BACK):
        ahead = np.array([0.0, 0.0, depth + back])
        worst = [
            np.where(counted, field.skin_depth(surface.frame.to_piece(skin + ahead)), 0.0).max(1)
            for skin, counted in parts
        ]
        if np.percentile(np.concatenate(worst), 95) < SHANK_CLEAR:
            return float(back)
    raise Unfit("no room for the shins")


def free_way(
    clip: Clip, phases: Phases, surface: SeatSurface, field: PieceField, until: int | None = None
) -> None:
    """Raise Unfit where the path to or from the seat collides with the piece. until: only frames before it."""
    frames = np.arange(len(clip))
    away = (frames < phases.down - 12) | (frames > phases.up_end + 12) if until is None else frames < until
    rows = _close(clip, surface, field, away, ON_THE_WAY if until is None else STRIDE)
    if len(rows) and field.deepest(*in_piece(clip, surface, rows))[0].max() > DEEPEST:
        raise Unfit("runs into it")


def _close(clip: Clip, surface: SeatSurface, field: PieceField, some: np.ndarray, stride: int) -> np.ndarray:
    """Return every stride-th of the flagged frames (T,) in which the body may touch the piece."""
    low, high = field.field.triangles.min((0, 1)), field.field.triangles.max((0, 1))
    at = surface.frame.to_piece(clip.root)
    near = ((at > low - 0.8) & (at < high + 0.8))[:, [0, 2]].all(1)
    return np.flatnonzero(near & some)[::stride]


def check(clip: Clip, phases: Phases, surface: SeatSurface, field: PieceField) -> None:
    """Raise Unfit where body and piece penetrate each other."""
    rows = _close(clip, surface, field, np.ones(len(clip), bool), STRIDE)
    if not len(rows):
        return
    at, rotations = in_piece(clip, surface, rows)
    deep, where = field.deepest(at, rotations)
    worst = int(deep.argmax())
    if deep[worst] > DEEPEST + field.give:
        raise Unfit(f"{group(str(where[worst]))} in it, {_when(int(rows[worst]), phases)}")


def in_piece(clip: Clip, surface: SeatSurface, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return root (R, 3) and rotations (R, 22, 4) of some frames in the piece's frame."""
    _, rotations = turned(clip.root[rows], clip.rotations[rows], surface.frame.yaw, np.zeros(3))
    return surface.frame.to_piece(clip.root[rows]), rotations


def _when(frame: int, phases: Phases) -> str:
    for name, last in (("before", phases.down - 1), ("sinking", phases.seated - 1), ("seated", phases.seat_end),
                       ("rising", phases.up_end)):  # fmt: skip
        if frame <= last:
            return name
    return "after"


def group(joint: str) -> str:
    """Return the part of the body to which a joint belongs."""
    name = joint.replace("left_", "").replace("right_", "")
    if name in ("pelvis", "hip"):
        return "seat"
    if name in ("knee", "ankle", "foot"):
        return "leg"
    if name in ("shoulder", "elbow", "wrist") or name[-1].isdigit() and not name.startswith("spine"):
        return "arm"
    return "trunk"
