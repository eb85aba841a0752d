"""Long-term as a method: sub-goals -> bodies -> routes and poses between them -> one take (Wang et al. 2021)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...errors import SampError, UsageError
from ..method import Draw, Option, checked_settings, require_place
from .installed import installed

if TYPE_CHECKING:
    from ...progress import Progress
    from ..scene_view import SceneView
    from ..step import Step
    from ..take import Failure, Take
    from .networks import Networks
    from .sub_goals.bodies import SubGoalBodies

# Numpy, scipy and torch are imported when a take is generated: the panel asks for a method's name at every redraw.


class LongTerm:
    """Synthesizing Long-Term 3D Human Motion and Interaction in 3D Scenes (Wang et al. 2021).

    networks: others than the trained ones.
    """

    name = "long_term"
    label = "Long-term"
    description = "Pass the sub-goals one after the other: stand, sit and lie at each, and move between them"
    actions = ("idle", "walk", "sit", "lie")
    needs = frozenset({"geometry", "target", "start", "destination", "goals", "via", "sub_goals"})
    options: tuple[Option, ...] = (
        Option(
            "sub_goals",
            "a place on a floor, a seat or a bed, and the facing in degrees; at least two, the first is the start",
            metavar=("X", "Y", "Z", "YAW"),
            repeated=True,
            switch="--sub-goal",
        ),
        Option(
            "pause",
            "seconds at each sub-goal but the last, a little more or less in each take",
            default=0.7,
            minimum=0.0,
            maximum=60.0,
        ),
    )
    batch_size = 8

    def __init__(self, networks: Networks | None = None) -> None:
        self._networks = networks

    def installed(self) -> bool:
        """Return whether the trained weights are there."""
        return self._networks is not None or installed()

    def check(self, step: Step) -> None:
        """Raise UsageError for sub-goals with an action's target or place, and for an action without.

        Without both, the step passes the sub-goals that are stored with the character in the scene.
        """
        places = step.settings.get("sub_goals") or ()
        if places:
            if len(places) < 2:
                raise UsageError(
                    "There is only one --sub-goal; give at least two, the first one is the start."
                )
            if not all(len(place) == 4 and all(map(math.isfinite, place)) for place in places):
                raise UsageError("--sub-goal needs the numbers X Y Z YAW.")
            if step.target or step.to is not None:
                raise UsageError("--sub-goal says where the take ends; leave out --target and --to.")
            return
        if not step.action:
            if step.target or step.to is not None:
                raise UsageError(
                    "Say what to do at the end with --action; --target and --to are for one action."
                )
            return  # the sub-goals that are stored with the character
        if step.action not in self.actions:
            raise UsageError(
                f"The method 'long_term' has no action '{step.action}'; choose one of {', '.join(self.actions)}."
            )
        require_place(step)

    def load(self) -> None:
        """Import torch and load the weights."""
        self._tools()

    def generate(
        self, step: Step, scene: SceneView, draws: Sequence[Draw], progress: Progress
    ) -> tuple[list[Take], list[Failure]]:
        """Return a take for each draw, and the failures; see Method.generate."""
        from ...clock import Clock
        from ...progress import SubProgress
        from ..samp import refusals
        from ..take import Failure
        from .request import Planner

        if not step.action and len(scene.sub_goals) + bool(scene.after) < 2:
            raise SampError(_too_few(len(scene.sub_goals)))
        clock = Clock()
        progress("Loading", 0.0)
        with clock.stage("load"):
            networks = self._tools()
        progress("Finding the floor", 0.0)
        with clock.stage("navmesh"):
            mesh = refusals.walkable(scene)
        planner = Planner(step, scene, networks, mesh, checked_settings(self, step.settings))
        takes, failures = [], []
        for number, draw in enumerate(draws):
            part = SubProgress(progress, number / len(draws), 1 / len(draws))
            try:
                takes.append(replace(planner.take(draw, clock, part), method=self.name))
            except SampError as error:
                failures.append(Failure(draw.seed, str(error)))
        return [replace(take, seconds=clock.seconds) for take in takes], failures

    def bodies(self, scene: SceneView) -> SubGoalBodies:
        """Return what draws bodies at the sub-goals of a scene. Raises SampError where nothing is walkable."""
        from ..samp import refusals
        from .sub_goals.bodies import SubGoalBodies
        from .surfaces import Surfaces
        from .synthesis import known_betas

        surfaces = Surfaces(scene.geometry.triangles, refusals.walkable(scene))
        return SubGoalBodies(self._tools(), surfaces, known_betas(scene.betas))

    def _tools(self) -> Networks:
        if self._networks is not None:
            return self._networks
        from . import networks

        return networks.load()


def _too_few(count: int) -> str:
    """Return the message for a scene with one sub-goal or none."""
    if count:
        return "There is only one sub-goal; add another one, the first one is the start."
    return (
        "There are no sub-goals; add some to the character in Blender, give --sub-goal X Y Z YAW at least twice, or "
        "say what to do with --action and --target."
    )


METHOD = LongTerm()
