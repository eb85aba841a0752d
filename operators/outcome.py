"""One report for each outcome: what an operator's work raised, or what it has to say."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..samp_addon.errors import SampError


def run(operator: bpy.types.Operator, work: Callable[[], str]) -> set[str]:
    """Does the work and reports the sentence it returns, or, for the artist to mend, the one it raises."""
    try:
        message = work()
    except SampError as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    operator.report({"INFO"}, message)
    return {"FINISHED"}
