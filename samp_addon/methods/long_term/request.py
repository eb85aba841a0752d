"""From a step to a take: its places, found or as the artist set them, and the take through them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...clock import Clock
from ...frames import yaw_direction
from ...motion import Goal, Motion
from ...progress import Progress, StageProgress
from ...scene.navmesh.navmesh import NavMesh
from ...vocabulary import SEATED
from ..method import Draw
from ..samp.planning import Planner as TargetPlanner
from ..scene_view import SceneView
from ..step import Step
from ..take import SubGoal, Take
from . import joining, planning, synthesis
from .figure import Figure
from .networks import Networks
from .planning import Leg
from .sub_goals import bodies, places
from .sub_goals.places import Place
from .surfaces import Surfaces

MOVED = 0.1
"""Metres beside the artist's point from which that is worth a remark."""


@dataclass(frozen=True)
class Planner:
    """The takes of one step. settings: the method's own options, defaults filled in."""

    step: Step
    scene: SceneView
    networks: Networks
    mesh: NavMesh
    settings: Mapping[str, Any]

    def take(self, draw: Draw, clock: Clock, progress: Progress) -> Take:
        """Return the take of a draw. Raise SampError where its places cannot be used."""
        rng = np.random.default_rng(draw.noise)
        progress("Choosing places", 0.0)
        figure = self._before(draw.seed)
        with clock.stage("path"):
            start, legs, remarks = self._legs(draw, clock, figure, rng)
        with clock.stage("motion"):
            motion, made = self._synthesis.take(start, legs, rng, figure, StageProgress(progress, "Moving"))
        last, line = legs[-1].stops[-1], np.concatenate([path for leg in legs for path in leg.paths])
        stops = [start, *(leg.stops[-1] for leg in legs)]
        facings = [
            yaw_direction(figure.facing(stop.action))
            for figure, stop in zip(made.figures, stops, strict=True)
        ]
        begun = joining.interaction_start(motion)
        motion = replace(motion, interaction_start=begun)
        action = self.step.action or last.action
        return Take(
            draw.seed,
            motion,
            goal=Goal(made.figures[-1].root, facings[-1], action),
            waypoints=line,
            sub_goals=tuple(
                SubGoal(figure.root, facing, frame)
                for figure, facing, frame in zip(made.figures, facings, made.frames, strict=True)
            ),
            laid_ground=self.mesh.laid_ground,
            remarks=remarks,
        )

    @cached_property
    def _synthesis(self) -> synthesis.Synthesis:
        return synthesis.Synthesis(
            self.networks,
            Surfaces(self.scene.geometry.triangles, self.mesh),
            synthesis.known_betas(self.scene.betas),
            bodies.noise_scale(self.step.style),
            self.step.speed,
            self.settings["pause"],
            self.step.hold,
        )

    def _before(self, seed: int) -> Figure | None:
        """Return the body in which the step before ended."""
        take = self.scene.after.get(seed)
        if take is None:
            return None
        return self._figure(take.motion, float(take.floor_end[1]))

    def _figure(self, motion: Motion, level: float) -> Figure:
        return synthesis.last_figure(motion, synthesis.known_betas(self.scene.betas), level)

    def _legs(
        self, draw: Draw, clock: Clock, figure: Figure | None, rng: np.random.Generator
    ) -> tuple[Place, list[Leg], tuple[str, ...]]:
        """Return where the take starts, its ways, and remarks for the artist."""
        if self.scene.sub_goals:
            stops, remarks = self._chosen
            if figure is not None:
                stops = [self._where(figure, draw.seed), *stops]
            return stops[0], planning.legs(self.mesh, stops, rng, self._synthesis.scale), remarks
        return self._to_target(draw, clock, figure)

    @cached_property
    def _chosen(self) -> tuple[list[Place], tuple[str, ...]]:
        """Return the artist's places, the same for all draws, and remarks about those that are moved."""
        stops, remarks = [], []
        for number, (point, yaw) in enumerate(self.scene.sub_goals, start=1):
            stop = places.find(self._synthesis.surfaces, point, yaw, f"Sub-goal {number}")
            if number <= len(self.scene.bodies) and self.scene.bodies[number - 1] is not None:
                seen = self._figure(self.scene.bodies[number - 1], float(stop.floor[1]))
                stops.append(replace(stop, body=seen))
                continue
            stops.append(stop)
            away = float(np.linalg.norm((stop.pelvis - point)[[0, 2]]))
            if away > MOVED:
                remarks.append(f"Sub-goal {number} is moved by {away:.2f} m to where the body fits.")
        return stops, tuple(remarks)

    def _where(self, figure: Figure, seed: int) -> Place:
        """Return the place of a body that another step has left."""
        take = self.scene.after[seed]
        resting = take.goal is not None and take.goal.action in SEATED
        action = take.goal.action if resting else "idle"
        return Place(action, figure.root, figure.facing(action), take.below_end)

    def _to_target(
        self, draw: Draw, clock: Clock, figure: Figure | None
    ) -> tuple[Place, list[Leg], tuple[str, ...]]:
        """Return the way to the target, whose goal GoalNet or the artist chooses, as for SAMP."""
        from ..samp.goals import sample_goals

        request = TargetPlanner(self.step, self.scene, sample_goals, self.mesh).request(draw, clock)
        line = request.waypoints
        if figure is None:
            start = places.standing(self._synthesis.surfaces, line[0], request.start_yaw, "The start")
        else:
            start = self._where(figure, draw.seed)
            line = np.concatenate([start.floor[None], line])
        yaw = float(np.arctan2(request.goal.direction[0], request.goal.direction[2]))
        if request.action in SEATED:
            end = places.seated(request.goal, yaw, self.mesh)
            line = np.concatenate([line, end.floor[None]])
        else:
            end = places.standing(self._synthesis.surfaces, line[-1], yaw, "The destination")
        if len(line) < 2:
            line = np.repeat(line, 2, axis=0)
        return start, [planning.divided(self.mesh, line, start, end)], request.remarks
