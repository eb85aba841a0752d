"""Grasping in the scene: the fingers of a hand on a target close around its mesh."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ...edits.grasping import grasp
from ...edits.hand_target import HandOnTarget
from ...errors import SampError
from ..scene import read_scene
from ..takes import seen


def grasped(
    context: bpy.types.Context, target: bpy.types.Object, made: HandOnTarget, begin: int
) -> tuple[HandOnTarget, int]:
    """Return a hand on a target with fingers that hold it, and how many of them touch it.

    An empty stands for its parent, such as a cup. begin: the scene's frame in which the motion begins. Raise SampError
    where the target has no surface, or is hidden.
    """
    frame = int(np.flatnonzero(made.contact.weight >= made.contact.weight.max())[0])
    thing = target.parent if target.type == "EMPTY" and target.parent is not None else target
    with seen.frame_kept(context.scene):
        context.scene.frame_set(begin + frame)
        try:
            surface = read_scene.read_target(context, thing).triangles
        except SampError as error:
            raise SampError(f"{str(error).rstrip('.')}, or turn off Grasp.") from error
    motion, touching = grasp(made.motion, made.contact, surface, frame)
    return replace(made, motion=motion), touching
