"""The palm of a hand: its middle on the skin, and where it faces. Network frame, metres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ... import rotation, skeleton

SIDES = ("left", "right")

ALONG = 0.75
"""Share of the way from the wrist to the middle finger's root at which the middle of the palm is."""

THICKNESS = 0.024
"""Metres from the bones of the hand to the skin of the palm."""

DOWN = np.array([0.0, -1.0, 0.0])
"""Where both palms face in the T-pose."""


@dataclass(frozen=True)
class HandContact:
    """A hand that is on something in some frames.

    side: "left" or "right". places: (T, 3) where the middle of the palm is to be. weight: (T,) from 0, where the hand
    is free, to 1, where it is on its place. facing: (T, 3) unit vectors that the palm faces, or None where any will do.
    """

    side: str
    places: np.ndarray
    weight: np.ndarray
    facing: np.ndarray | None = None

    def cut(self, part: slice) -> HandContact:
        """Return the contact in some frames."""
        facing = None if self.facing is None else self.facing[part]
        return replace(self, places=self.places[part], weight=self.weight[part], facing=facing)

    def between(self, first: int, last: int) -> HandContact:
        """Return the contact in frames first to last, free where these lie before or after its own."""
        rows = np.arange(first, last + 1)
        at = np.clip(rows, 0, len(self.weight) - 1)
        facing = None if self.facing is None else self.facing[at]
        return replace(self, places=self.places[at], weight=self.weight[at] * (rows == at), facing=facing)

    def without(self, frames: np.ndarray) -> HandContact:
        """Return the contact, free in flagged frames (T,)."""
        return replace(self, weight=np.where(frames, 0.0, self.weight))

    def stored(self) -> dict:
        """Return the contact as plain numbers, for a note or a file."""
        held = {"side": self.side, "places": self.places.ravel().tolist(), "weight": self.weight.tolist()}
        return held if self.facing is None else held | {"facing": self.facing.ravel().tolist()}

    @classmethod
    def of(cls, stored: Mapping) -> HandContact:
        """Return what `stored` gave."""
        table = lambda key: np.array(stored[key], dtype=np.float64)
        facing = table("facing").reshape(-1, 3) if "facing" in stored else None
        return cls(stored["side"], table("places").reshape(-1, 3), table("weight"), facing)


def offset(rest_joints: np.ndarray, side: str) -> np.ndarray:
    """Return the middle of the palm relative to the wrist (3,), in the wrist's frame. rest_joints: (22 or 55, 3)."""
    whole = rest_joints if len(rest_joints) == len(skeleton.JOINTS) else skeleton.default_rest_joints()
    hand = whole[skeleton.INDEX[f"{side}_middle1"]] - whole[skeleton.INDEX[f"{side}_wrist"]]
    return ALONG * hand + THICKNESS * DOWN


def palm(
    positions: np.ndarray, globals_: np.ndarray, rest_joints: np.ndarray, side: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the middle of the palm (T, 3) and the direction that it faces (T, 3).

    positions: (T, J, 3) and globals_: (T, J, 4) of the joints, as forward kinematics gives them.
    """
    wrist = skeleton.INDEX[f"{side}_wrist"]
    turned = globals_[:, wrist]
    middle = positions[:, wrist] + rotation.rotate(turned, offset(rest_joints, side))
    return middle, rotation.rotate(turned, DOWN)


def at_frames(contacts: Sequence[HandContact], first: int, last: int) -> tuple[HandContact, ...]:
    """Return contacts in frames first to last, those that are on something there."""
    part = [contact.cut(slice(first, last + 1)) for contact in contacts]
    return tuple(contact for contact in part if contact.weight.any())
