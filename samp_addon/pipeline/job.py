"""What is asked for: one job, from a command line, a line of a jobs file or an operator.

Blender's world, as the artist sees it: metres, Z up; yaw in degrees, 0 faces -Y, positive turns left.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from ..body import body_shape
from ..errors import UsageError
from ..methods import registry
from ..methods.method import checked_settings
from ..methods.step import Step
from . import hand_request

MOST_VARIANTS = 1000
LARGEST_SEED = 2**31 - 1


@dataclass(frozen=True)
class Job:
    """Takes of one action, or of several in a row, in one scene.

    action, target, point, to, method, hold, style, speed, via, path and settings: of the first step, see Step; hold,
    style and speed are those of all steps. character: name of an SMPL-X armature; empty: the caller's choice. shape:
    measures of the default human where it is made, see body/body_shape.py. start: (x, y, z, yaw), or None for where the
    character stands, or a free place. seed: of the first take; variants: how many takes. refine: whether contact,
    penetration and foot slide of each take are corrected. then: the steps after the first, in the same takes. hand:
    what hands are on, see hand_request.py. Raises UsageError for values that cannot be used.
    """

    action: str = "sit"
    target: str = ""
    point: tuple[float, ...] | None = None
    to: tuple[float, ...] | None = None
    character: str = ""
    shape: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    start: tuple[float, float, float, float] | None = None
    seed: int = 0
    variants: int = 1
    refine: bool = False
    method: str = registry.DEFAULT
    hold: float = 2.0
    style: float = 0.1
    speed: float = 1.0
    via: tuple[tuple[float, float, float], ...] = ()
    path: str = ""
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    then: tuple[Step, ...] = ()
    hand: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not 1 <= self.variants <= MOST_VARIANTS:
            raise UsageError(f"--variants is {self.variants}; choose from 1 to {MOST_VARIANTS}.")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise UsageError(f"--seed is {self.seed}; choose from 0 to {LARGEST_SEED}.")
        if self.start is not None and not (len(self.start) == 4 and all(map(math.isfinite, self.start))):
            raise UsageError("--start needs the numbers X Y Z YAW.")
        if self.shape and self.character:
            raise UsageError("--shape is of the human that is made; leave out --character.")
        body_shape.check(self.shape)
        for text in self.hand:
            hand_request.parse(text)
        for step in self.steps:
            method = registry.find(step.method)
            checked_settings(method, step.settings)
            method.check(step)

    @property
    def seeds(self) -> range:
        """The takes' seeds, from `seed` upward."""
        return range(self.seed, self.seed + self.variants)

    @property
    def steps(self) -> tuple[Step, ...]:
        """The single actions in their order."""
        shared = {"hold": self.hold, "style": self.style, "speed": self.speed}
        own = ("action", "target", "point", "to", "method", "via", "path", "settings")
        first = Step(**{name: getattr(self, name) for name in own}, **shared)
        return (first, *(replace(step, **shared) for step in self.then))
