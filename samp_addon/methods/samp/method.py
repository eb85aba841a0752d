"""SAMP as a method: target and action -> goal (GoalNet) -> path (navmesh, A*) -> motion (MotionNet); figure 2."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...errors import SampError, UsageError
from ...vocabulary import ACTIONS, POSTURE_NAMES, POSTURES, SEATED
from ..method import Draw, Option, require_place
from . import postures, weights_file

if TYPE_CHECKING:
    import numpy as np

    from ...clock import Clock
    from ...motion import Goal, Motion
    from ...progress import Progress
    from ..scene_view import SceneView
    from ..step import Step
    from ..take import Failure, Take
    from .networks import Networks
    from .planning import Planner
    from .request import Request

# Numpy, scipy and torch are imported when a take is generated: the panel asks for a method's name at every redraw.


POSTURE = Option(
    "posture",
    f"how the body rests, with commas between those that go together: {', '.join(POSTURE_NAMES)}; left out, drawn as "
    "people rest",
    kind=str,
    metavar=("POSTURE",),
    choices=POSTURE_NAMES,
    for_actions=POSTURES,
)


class Samp:
    """Stochastic Scene-Aware Motion Prediction (Hassan et al. 2021).

    networks: others than the trained ones.
    """

    name = "samp"
    label = "SAMP"
    description = "Walk to the target and sit, lie or stand there, frame by frame"
    actions = ACTIONS
    needs = frozenset({"geometry", "target", "start", "destination", "goals", "via"})
    batch_size = 32

    def __init__(self, networks: Networks | None = None) -> None:
        self._networks = networks

    @property
    def options(self) -> tuple[Option, ...]:
        """The posture of a rest, where the weights know postures."""
        return (POSTURE,) if weights_file.knows_postures() else ()

    def installed(self) -> bool:
        """Return True: the weights are part of the extension."""
        return True

    def check(self, step: Step) -> None:
        """Raise UsageError where the action's target or place is missing or is not for it."""
        if not step.action:
            raise UsageError("Say what to do with --action: " + ", ".join(self.actions) + ".")
        if step.action not in self.actions:
            raise UsageError(f"There is no action '{step.action}'; choose one of {', '.join(self.actions)}.")
        require_place(step)
        if step.action in SEATED and step.to is not None:
            raise UsageError(f"--to is for walk and run; to {step.action}, name a --target.")
        postures.parse(step.settings.get("posture"))

    def postures_at(self, goal: Goal, triangles: np.ndarray) -> tuple[str, ...]:
        """Return the postures that a body can be asked for at a goal among triangles (F, 3, 3)."""
        from . import posture_places

        if not self.options or goal.action != "sit":
            return ()  # lying bodies were captured on their backs only
        there = posture_places.around(triangles, goal)
        wanted = POSTURES[goal.action]
        return tuple(name for name in wanted if name not in postures.NEEDS_PLACE or name in there)

    def load(self) -> None:
        """Import torch and the rollout, and read the weights. Raise SampError where they are damaged."""
        self._tools()
        from .load_networks import load_goal_net, load_motion_net

        load_motion_net()
        load_goal_net()

    def generate(
        self, step: Step, scene: SceneView, draws: Sequence[Draw], progress: Progress
    ) -> tuple[list[Take], list[Failure]]:
        """Return a take for each draw, rolled out as one batch, and the failures; see Method.generate."""
        return self.generate_together([(step, scene, draws)], progress)[0]

    def generate_together(
        self, parts: Sequence[tuple[Step, SceneView, Sequence[Draw]]], progress: Progress
    ) -> list[tuple[list[Take], list[Failure]]]:
        """Return takes and failures of several steps in scenes of their own, all rolled out as one batch."""
        from ...clock import Clock
        from ...progress import StageProgress
        from ..take import Failure

        clock = Clock()
        progress("Loading", 0.0)
        with clock.stage("load"):
            networks = self._tools()
        made: list[tuple[list[Take], list[Failure]]] = [([], []) for _ in parts]
        planned: list[tuple[int, int, Planner, Request]] = []
        for number, (step, scene, draws) in enumerate(parts):
            try:
                planner = self._planner(step, scene, networks, progress, clock)
            except SampError as error:
                if len(parts) == 1:
                    raise
                made[number][1].extend(Failure(draw.seed, str(error)) for draw in draws)
                continue
            for draw in draws:
                progress("Choosing a place", 0.0)
                try:
                    planned.append((number, draw.seed, planner, planner.request(draw, clock)))
                except SampError as error:
                    made[number][1].append(Failure(draw.seed, str(error)))
        with clock.stage("rollout"):
            requests = [request for *_, request in planned]
            motions = networks.generate(requests, StageProgress(progress, "Moving"))
        for (number, seed, planner, request), motion in zip(planned, motions, strict=True):
            if isinstance(motion, SampError):
                made[number][1].append(Failure(seed, str(motion)))
            else:
                take = planner.take(seed, request, _paced(motion, planner.step.speed))
                made[number][0].append(replace(take, method=self.name))
        return [([replace(take, seconds=clock.seconds) for take in takes], failed) for takes, failed in made]

    @staticmethod
    def _planner(
        step: Step, scene: SceneView, networks: Networks, progress: Progress, clock: Clock
    ) -> Planner:
        from . import refusals
        from .planning import Planner

        progress("Finding the floor", 0.0)
        with clock.stage("navmesh"):
            return Planner(step, scene, networks.sample_goals, refusals.walkable(scene))

    def _tools(self) -> Networks:
        return self._networks or trained_networks()


def trained_networks() -> Networks:
    """Return the trained networks. Imports torch."""
    from . import networks

    return networks.trained()


def _paced(motion: Motion, speed: float) -> Motion:
    """Return the motion faster or slower by a factor, at the same frame rate."""
    return motion if speed == 1 else replace(motion, fps=motion.fps * speed).resampled(motion.fps)


METHOD = Samp()
