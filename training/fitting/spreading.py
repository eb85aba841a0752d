"""Distribute a correction of the seated pose over sitting down, the hold and standing up, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...samp_addon import rotation
from ...samp_addon.easing import anticipate, smoothstep
from ..mocap.clip_files import Clip
from . import hold as holds
from .hold import Hold
from .shapes import posing
from .shapes.surfaces import SeatSurface

HARDLY_LOWER = 0.2  # descent (m) of the pelvis below which the weight follows time instead of height
LEAD, LAG = 4, 14  # frames before sitting down and after being seated over which such a way is spread
SETTLED = 0.035  # metres from the seated pelvis within which a body is at rest
HANGING = (0.11, 0.18)  # metres of an ankle over the floor between which a foot begins to hang
SNAP = (np.radians(7), np.radians(14))  # leaning forward by so much from the hold, a back leaves its rest
EVEN = 4.0  # frames, standard deviation
LEVER = 0.35  # metres from the hips to where a back leans
LOW = 0.12  # metres over the pelvis up to which it is the pelvis that has to go forward
PASSES = 3
CLEAR = 0.002  # metres


@dataclass(frozen=True)
class Phases:
    """Frames of a sit in a clip: down <= seated <= seat_end <= up_end."""

    down: int
    seated: int
    seat_end: int
    up_end: int

    @property
    def hold(self) -> slice:
        """The seated frames, without the first and last ones if there are enough."""
        margin = min(6, (self.seat_end - self.seated) // 4)
        return slice(self.seated + margin, self.seat_end + 1 - margin)


def sinking(root: np.ndarray, phases: Phases) -> np.ndarray:
    """Return the weight (T,) of the seated pose: 0 standing, 1 seated, following the pelvis down and up."""
    count = len(root)
    frames = np.arange(count)
    seated = float(np.median(root[phases.hold, 1]))
    standing = float(np.percentile(root[:, 1], 95))
    stays = phases.up_end <= phases.seat_end  # the clip ends seated
    time = smoothstep((frames - phases.down + LEAD) / (phases.seated - phases.down + LEAD + LAG))
    if not stays:
        rising = (phases.up_end + LEAD - frames) / (phases.up_end - phases.seat_end + 2 * LEAD)
        time = np.minimum(time, smoothstep(rising))
    if standing - seated < HARDLY_LOWER:
        return time
    weight = smoothstep((standing - root[:, 1]) / (0.97 * (standing - seated)))
    weight[phases.hold] = np.maximum(weight[phases.hold], time[phases.hold])
    # Exclude the vertical motion of steps before and after.
    window = smoothstep((frames - phases.down + 15) / 15.0)
    if not stays:
        window = np.minimum(window, smoothstep((phases.up_end + 15 - frames) / 15.0))
    return gaussian_filter1d(weight * window, 1.5, mode="nearest")


def resting(root: np.ndarray, phases: Phases) -> np.ndarray:
    """Return the weight (T,) of the frames in which the pelvis rests on its seat."""
    middle = np.median(root[phases.hold], axis=0)
    near = np.linalg.norm(root - middle, axis=-1) < SETTLED
    frames = np.arange(len(root))
    near &= (frames >= phases.seated) & (frames <= phases.seat_end)
    return gaussian_filter1d(near.astype(float), EVEN, mode="nearest")


def spread(
    clip: Clip, phases: Phases, found: Hold, reference: int, surface: SeatSurface, give: float
) -> Clip:
    """Return the clip, in the seat frame with its feet in place, brought into the hold and out of it."""
    weight, rests = sinking(clip.root, phases), resting(clip.root, phases)
    places, feet = posing.ankles(clip.root, clip.rotations)
    shift = np.array([0.0, found.height, found.depth]) - clip.root[reference] * [0.0, 1.0, 1.0]
    places = {side: place + _hanging(place) * (weight * shift[1])[:, None] for side, place in places.items()}
    ahead = np.array([0.0, 0.0, 1.0])
    lean = posing.trunk_lean(clip.root, clip.rotations, ahead)
    usual = float(lean[reference])
    snap = smoothstep(1 - (np.abs(lean - usual) - SNAP[0]) / (SNAP[1] - SNAP[0])) * rests
    places, feet = posing.tiptoed(places, feet, weight * found.heels)
    root = clip.root + weight[:, None] * shift
    pelvis, spine = weight * found.pelvis, weight * found.spine
    rows = _near(weight)
    for number in range(PASSES + 1):
        rotations = posing.planted(root, posing.leant(clip.rotations, pelvis, spine), places, feet)
        if number < PASSES:
            forward, bend = _bend(
                root, rotations, surface, give, snap if found.mode == "leaning" else None, rows
            )
            lift = _lift(root, rotations, surface, give, rests, rows)
            root = root + np.stack([np.zeros_like(lift), lift, forward], -1)
            spine = spine + bend
    return _with(clip, root, posing.flat_toes(rotations, weight * found.heels))


def _with(clip: Clip, root: np.ndarray, rotations: np.ndarray) -> Clip:
    return replace(clip, root=root, rotations=rotation.continuous(rotations))


def _hanging(place: np.ndarray) -> np.ndarray:
    """Return the displacement (T, 3) of ankles (T, 3) per metre of the seat's rise: hanging feet follow it."""
    high = smoothstep(
        (gaussian_filter1d(place[:, 1], 3, mode="nearest") - HANGING[0]) / (HANGING[1] - HANGING[0])
    )
    return high[:, None] * np.array([0.0, 1.0, 0.0])


def _near(weight: np.ndarray) -> np.ndarray:
    """Return every third frame with a non-zero correction, and the last."""
    some = np.flatnonzero(weight > 0.02)
    return np.union1d(some[::3], some[-1:])


def _lift(root, rotations, surface, give, rests, rows) -> np.ndarray:  # noqa: ANN001
    """Return the lift (T,), metres: onto the seat while resting, only out of it before and after."""
    contact, lowest = holds.seat_gap(root[rows], rotations[rows], surface)
    out = np.maximum(-lowest - give - CLEAR - holds.PRESSED * 2, 0.0)
    onto = -(np.clip(contact, -0.06, 0.06) + holds.PRESSED + 0.5 * give)
    share = rests[rows]
    wanted = share * onto + (1 - share) * out
    every = np.arange(len(root))
    wanted = np.interp(every, rows, wanted, left=0.0, right=wanted[-1])
    free = np.interp(every, rows, out, left=0.0, right=out[-1])
    return np.maximum(gaussian_filter1d(wanted, EVEN, mode="nearest"), 0.9 * anticipate(free, 5, 2.0))


def _bend(root, rotations, surface, give, snap, rows) -> tuple[np.ndarray, np.ndarray]:  # noqa: ANN001
    """Return how far the pelvis moves forward (T,), metres, and the spine bends forward (T,), radians.

    Both move the body out of the back; with snap (T,), the spine is also bent back onto it.
    """
    over, ahead = holds.back_distances(root[rows], rotations[rows], surface)
    inside = np.maximum(-ahead - CLEAR, 0.0)
    low = over < LOW
    every = np.arange(len(root))
    spread_out = lambda some, n, even: anticipate(
        np.interp(every, rows, some, left=0.0, right=some[-1]), n, even
    )
    forward = spread_out(np.where(low, inside, 0.0).max(1), 7, 3.0)
    out = spread_out((np.where(low, 0.0, inside) / np.maximum(over, LOW)).max(1), 7, 3.0)
    if snap is None:
        return forward, out
    gap = np.sort(np.where(over > LOW, ahead, 1.0), 1)[:, :4].mean(1) + 0.4 * give
    onto = np.where(gap < 0.2, np.maximum(gap, 0.0), 0.0) / LEVER * snap[rows]
    back = gaussian_filter1d(np.interp(every, rows, onto, left=0.0, right=onto[-1]), EVEN, mode="nearest")
    return forward, out - 0.9 * back
