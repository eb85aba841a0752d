"""A member of a cast with all that is known of its scene, and the work of a whole cast. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...body.balls import Track
from ...body.human import Human
from ...methods.scene_view import SceneView
from ...methods.step import Step
from ...refine.refinement import Surroundings
from ...vocabulary import SEATED
from ..job import Job
from .cast import Cast, Member


@dataclass(frozen=True)
class Role:
    """A member and its scene.

    pieces: names of the furniture of which its last action takes one; a single name, maybe empty, where there is no
    choice. views: for each of these, the scene as each step sees it. body: the character's. looks_at: the point (3,) or
    the number of the member that it looks at in the end, or None.
    """

    member: Member
    pieces: tuple[str, ...]
    views: tuple[tuple[SceneView, ...], ...]
    body: Human
    looks_at: np.ndarray | int | None = None

    @property
    def action(self) -> str:
        """The last action."""
        return self.member.job.steps[-1].action

    @property
    def seated(self) -> bool:
        """Whether the member sits or lies in the end."""
        return self.action in SEATED and self.views[0][-1].target is not None

    def steps(self, option: int) -> list[tuple[Step, SceneView]]:
        """Return the steps and their views where the last action is on one of the pieces."""
        steps = self.job_on(self.pieces[option]).steps
        return list(zip(steps, self.views[option], strict=True))

    def job_on(self, piece: str) -> Job:
        """Return the member's job with its last action on a piece of furniture."""
        job = self.member.job
        if not job.then:
            return replace(job, target=piece)
        return replace(job, then=(*job.then[:-1], replace(job.then[-1], target=piece)))

    def starting(self, start: tuple[np.ndarray, float]) -> Role:
        """Return the role with another start."""
        views = tuple((replace(own[0], start=start), *own[1:]) for own in self.views)
        return replace(self, views=views)

    def ending(self, destination: tuple[np.ndarray, float | None]) -> Role:
        """Return the role with another destination."""
        views = tuple((*own[:-1], replace(own[-1], destination=destination)) for own in self.views)
        return replace(self, views=views)


@dataclass(frozen=True)
class Other:
    """A body that is not of the cast. track: from the cast's first frame on. pelvis: (3,) where it is in the end."""

    name: str
    track: Track
    pelvis: np.ndarray


@dataclass(frozen=True)
class CastWork:
    """A cast and all that is known of its scene. surroundings: what takes are refined against, or None."""

    cast: Cast
    roles: Sequence[Role]
    others: Sequence[Other] = ()
    surroundings: Surroundings | None = None
