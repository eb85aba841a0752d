"""One step of a job: what a method is asked to make. Blender's world: metres, Z up; yaw in degrees, 0 faces -Y."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from ..errors import UsageError

SLOWEST, FASTEST = 0.5, 2.0
LONGEST_HOLD = 3600  # seconds


@dataclass(frozen=True)
class Step:
    """One action by one method.

    action: one of the method's actions; empty for a method that has none. target: name of an object, empty or
    collection. point: (x, y, z) on the target; in a whole room it selects the piece. With a yaw it is the place
    itself, on the surface below the pelvis, and the facing. to: place (x, y, z) or (x, y, z,
    yaw) to go to. method: a name of the registry. hold: seconds at the end. style: how much takes differ from the most
    common one, 0 to 1. speed: factor on the speed of captured motion. via: places (x, y, z)
    that the path passes, in order. path: name of a curve that it follows after these. settings: values of the method's
    own options, by name. Raises UsageError for values that no method can use.
    """

    action: str = "sit"
    target: str = ""
    point: tuple[float, ...] | None = None
    to: tuple[float, ...] | None = None
    method: str = "samp"
    hold: float = 2.0
    style: float = 0.1
    speed: float = 1.0
    via: tuple[tuple[float, float, float], ...] = ()
    path: str = ""
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        if not 0 <= self.hold <= LONGEST_HOLD:
            raise UsageError(f"--hold is {self.hold}; choose from 0 to {LONGEST_HOLD} seconds.")
        if not 0 <= self.style <= 1:
            raise UsageError(f"--style is {self.style}; choose from 0 to 1.")
        if not SLOWEST <= self.speed <= FASTEST:
            raise UsageError(f"--speed is {self.speed}; choose from {SLOWEST} to {FASTEST}.")
        if self.to is not None and not _finite(self.to, (3, 4)):
            raise UsageError("--to needs the numbers X Y Z [YAW].")
        if self.point is not None and not _finite(self.point, (3, 4)):
            raise UsageError("The point on the target needs the numbers X Y Z [YAW].")
        if not all(_finite(place, (3,)) for place in self.via):
            raise UsageError("--via needs the numbers X Y Z of each place.")


def _finite(numbers: tuple[float, ...], lengths: tuple[int, ...]) -> bool:
    return len(numbers) in lengths and all(map(math.isfinite, numbers))
