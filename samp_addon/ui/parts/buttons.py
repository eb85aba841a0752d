"""Buttons of long work, which become a progress bar while it runs."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ...blender import running_work


def draw(
    layout: bpy.types.UILayout, operator: str, text: str = "", icon: str = "NONE", also: Sequence[str] = ()
) -> bpy.types.OperatorProperties | None:
    """Draw the button of an operator, or the progress of its work; return the button's options.

    operator: without "samp.". text: by default the operator's label. also: operators that have no button of their own,
    whose progress is shown here.
    """
    work = running_work.current()
    if work is None or work.operator not in (operator, *also):
        words = {"text": text} if text else {}
        return layout.operator(f"samp.{operator}", icon=icon, **words)
    column = layout.column(align=True)
    column.progress(factor=work.share, text=f"{work.label}: {work.stage}")
    column.operator("samp.stop", icon="CANCEL")
    return None
