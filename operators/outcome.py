"""One report for each outcome: what an operator's work raised, or what it has to say."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..samp_addon import dependencies
from ..samp_addon.errors import SampError


def run(
    operator: bpy.types.Operator, work: Callable[[], str], finished: set[str] = frozenset({"FINISHED"})
) -> set[str]:
    """Does the work and reports the sentence it returns, or, for the artist to mend, the one it raises.

    finished: what the operator returns if all went well. An empty sentence is not reported.
    """
    try:
        message = work()
    except SampError as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    except (ImportError, OSError) as error:
        told = dependencies.explain(error)
        if told is None:
            raise
        operator.report({"ERROR"}, told)
        return {"CANCELLED"}
    if message:
        operator.report({"INFO"}, message)
    return set(finished)


def in_object_or_pose_mode(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether an operator that works in these two modes can run; its tooltip says why not."""
    if context.mode not in {"OBJECT", "POSE"}:
        operator.poll_message_set("Go to Object or Pose Mode first")
        return False
    return True


def in_object_mode(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether an operator that works in Object Mode alone can run; its tooltip says why not."""
    if context.mode != "OBJECT":
        operator.poll_message_set("Go to Object Mode first")
        return False
    return True
