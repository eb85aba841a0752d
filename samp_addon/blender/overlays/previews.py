"""Single stages of a job, each drawn into the scene: voxel grid, navmesh and path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy
import numpy as np

from ... import frames
from ...errors import SampError
from ...motion import Goal
from ...scene.navmesh import navmesh as navigation
from ...scene.navmesh import path as paths
from ...scene.navmesh.navmesh import Agent, NavMesh
from ...scene.navmesh.path import Path
from ...scene.seats import seats
from ...scene.voxels import InteractionGrid
from ..character import armature, characters
from ..scene import pieces, read_scene
from ..scene.read_scene import Target
from . import drawing, goal_arrows, start_marker, waypoints


def voxelise(context: bpy.types.Context, target: str) -> tuple[bpy.types.Object, InteractionGrid]:
    """Voxelise a piece of furniture; return the overlay object and the grid."""
    furniture = read_scene.read_target(context, target, characters.people(context))
    yaw = seats.infer_front_yaw(furniture.triangles)
    grid = InteractionGrid.build(furniture.triangles, yaw, furniture.name)
    return drawing.draw_grid(context, grid, furniture.name), grid


def build_navmesh(
    context: bpy.types.Context, agent: Agent | None = None, cell: float = navigation.CELL
) -> tuple[bpy.types.Object, NavMesh]:
    """Build the scene's navmesh; return the overlay object and the navmesh. cell: metres."""
    scene = read_scene.read_scene(context, characters.people(context))
    mesh = navigation.build(scene.triangles, agent, cell)
    return drawing.draw_navmesh(context, mesh), mesh


def plan_path(
    context: bpy.types.Context,
    target: str | None = None,
    to: Sequence[float] | None = None,
    start: Sequence[float] | None = None,
    action: str = "sit",
) -> tuple[bpy.types.Object, Path]:
    """Plan the path to a piece of furniture or to a point; return the overlay curve and the path.

    target: name of the furniture; the path ends in front of its first goal (the artist's arrows first). to: (3,)
    a point instead. start: (3,); by default the character's start marker, or the 3D cursor without a character. Points
    in metres, in Blender's world. The path passes the artist's way-points. Raise SampError where there is no goal or no
    path.
    """
    people = characters.people(context)
    scene = read_scene.read_scene(context, people)
    begin = _start(context) if start is None else frames.to_network(np.array(start))
    goal = end = None
    if to is not None:
        end = frames.to_network(np.array(to))
    elif target:
        furniture = read_scene.read_target(context, target, people)
        scene, furniture = pieces.piece(context, scene, furniture, action)
        others = scene.without(furniture.parts).triangles
        goal = _goal_on(context, furniture, action, others)
        end = goal.position
    else:
        raise SampError("The path has no end; give a target or a point.")
    via = waypoints.positions(context)
    mesh = navigation.build(scene.triangles, cover=np.stack([begin, *via, end]))
    legs = []
    for place in via:
        legs.append(paths.plan(mesh, begin, place).waypoints)
        begin = legs[-1][-1]
    last = paths.plan(mesh, begin, end) if goal is None else paths.plan_to_goal(mesh, begin, goal)
    path = replace(last, waypoints=np.concatenate([*(leg[:-1] for leg in legs), last.waypoints]))
    return drawing.draw_path(context, path), path


def _start(context: bpy.types.Context) -> np.ndarray:
    """Return the floor point (3,) at which the character's takes start, or the 3D cursor; metres, network frame."""
    if not any(armature.is_smplx(obj) for obj in context.scene.objects):
        return frames.to_network(np.array(context.scene.cursor.location))
    return start_marker.place(context, armature.find(context))[0]


def _goal_on(context: bpy.types.Context, furniture: Target, action: str, others: np.ndarray) -> Goal:
    chosen = goal_arrows.read_goals(context, furniture, action)
    if not chosen:
        chosen = seats.find_goals(furniture.triangles, action, obstacles=others, limit=1)
    if not chosen:
        raise SampError(f"There is no place to {action} on '{furniture.name}'; choose another object.")
    return chosen[0]
