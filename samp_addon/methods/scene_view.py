"""What a method knows of the artist's scene for one step. Network frame, metres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

import numpy as np

from ..body.balls import Track
from ..motion import Goal, Motion
from ..scene.camera_view import CameraView
from ..scene.geometry import SceneGeometry, extent
from ..scene.navmesh import navmesh as navigation
from ..scene.navmesh import occupied as occupation
from ..scene.navmesh.occupied import Disc
from ..scene.navmesh.shared import shared
from .take import Take

SIDEWAYS = 0.12
"""Metres: radius of a character that walks sideways through a gap."""

UPRIGHT = navigation.Agent(radius=0.18, step=0.6)
"""The room for a pelvis that sinks onto a seat while the trunk leans forward over low things."""


@dataclass(frozen=True)
class SceneView:
    """The scene as one step sees it; a method's `needs` names the fields that are filled in.

    geometry: all triangles, the target's too, characters' not. target: (F, 3, 3) of what the action is about, or None.
    parts: names of the target's objects in `geometry`. start: floor position (3,) and yaw in radians, or None for a
    free place. destination: floor position (3,) and yaw or None. goals: places on the target that the artist has
    chosen. via: floor positions (3,) that the path passes, in order. sub_goals: points (3,) on floors, seats and beds
    with yaws in radians, in order, the start first. bodies: for each sub-goal the body that the artist has seen there,
    one frame in the default proportions, or None where the method chooses; empty for none at all. camera: what the
    step's camera sees, or None. betas: (10,) shape of the character, see body/betas.py; None for the default human and
    for bodies from elsewhere. characters: names of objects in `geometry` that are other characters' bodies, with the
    characters' names. after: by seed, the takes that these go on from; `start` counts for nothing then. occupied:
    ground that is left to other bodies. others: these bodies over time, from the first frame of the step on.
    """

    geometry: SceneGeometry
    target: np.ndarray | None = None
    parts: Sequence[str] = ()
    start: tuple[np.ndarray, float] | None = None
    destination: tuple[np.ndarray, float | None] | None = None
    goals: Sequence[Goal] = ()
    via: Sequence[np.ndarray] = ()
    sub_goals: Sequence[tuple[np.ndarray, float]] = ()
    bodies: Sequence[Motion | None] = ()
    camera: CameraView | None = None
    betas: np.ndarray | None = None
    characters: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    after: Mapping[int, Take] = field(default_factory=lambda: MappingProxyType({}))
    occupied: Sequence[Disc] = ()
    others: Sequence[Track] = ()

    @cached_property
    def explained(self) -> dict[str, Exception]:
        """Errors of a method that were explained before, by what they are about: explaining takes seconds."""
        return {}

    @cached_property
    def navmesh(self) -> navigation.NavMesh:
        """The walkable ground, around all places that this step is about."""
        return self._walkable(self.geometry, navigation.Agent())

    @cached_property
    def narrow_navmesh(self) -> navigation.NavMesh:
        """The ground that can be walked on sideways as well, as between two rows of seats."""
        return self._walkable(self.geometry, navigation.Agent(radius=SIDEWAYS))

    @cached_property
    def room_to_sit_down(self) -> navigation.NavMesh:
        """Where a body has room between other things than the target; their low tops belong to it."""
        return self._walkable(self.geometry.without(self.parts), UPRIGHT)

    def _walkable(self, geometry: SceneGeometry, agent: navigation.Agent) -> navigation.NavMesh:
        places = [goal.position for goal in self.goals] + [take.floor_end for take in self.after.values()]
        places += [point for point, _ in self.sub_goals]
        for place in (self.start, self.destination):
            if place is not None:
                places.append(place[0])
        if self.target is not None:
            places += extent(self.target)
        cover = np.array(places).reshape(-1, 3)
        return occupation.without(shared(geometry.triangles, agent, cover), self.occupied)
