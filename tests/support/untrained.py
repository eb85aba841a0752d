"""The long-term method with random weights, and a room for it: for tests of everything around the networks."""

from __future__ import annotations

import functools

import bpy
import numpy as np
import rooms
import torch
from samp_blender.models.long_term import guided_pose, guided_route, pose_prior, sub_goal_net
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.methods.long_term.method import LongTerm
from samp_blender.samp_addon.methods.long_term.networks import Networks

FLOOR, FAR, SEAT, BED = (0.5, 1.0, 0.0), (-1.5, -1.5, 0.0), (2.0, -1.95, 0.45), (-2.2, -1.4, 0.5)
"""Points in Blender's world: on the floor, there too, on the seat, and on the bed."""
AIR, SHELF = (0.0, 0.0, 1.2), (3.0, 3.0, 1.2)
BOXES = {
    "Floor": [((-4, -0.1, -4), (4, 0, 4))],
    "Seat": [((1.6, 0.3, 1.75), (2.4, 0.45, 2.3)), ((1.6, 0.45, 2.25), (2.4, 0.95, 2.35))],
    "Bed": [((-2.7, 0.2, 0.4), (-1.7, 0.5, 2.6)), ((-2.7, 0.2, 2.6), (-1.7, 1.0, 2.7))],
    "Shelf": [((2.9, 0.0, -3.1), (3.1, 1.2, -2.9))],
}
"""Network frame: the seat faces -Z, the bed has its head towards +Z."""


@functools.cache
def method() -> LongTerm:
    """Return the method around networks that have learnt nothing."""
    torch.manual_seed(3)
    kinds = (pose_prior.PosePrior, sub_goal_net.SubGoalNet, guided_route.GuidedRoute, guided_pose.GuidedPose)
    return LongTerm(Networks(*(kind().eval() for kind in kinds)))


def furnish(scene: bpy.types.Scene) -> None:
    """Add the room to a scene."""
    for name, boxes in BOXES.items():
        triangles = np.concatenate([rooms.box(*corners) for corners in boxes])
        mesh = bpy.data.meshes.new(name)
        points = frames.to_blender(triangles.reshape(-1, 3))
        mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))
