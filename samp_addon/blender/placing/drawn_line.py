"""A line that the mouse draws on the floor, for Draw Path and Place."""

from __future__ import annotations

import bpy
import numpy as np

from ..overlays import waypoints
from ..sub_goals import clicking
from . import strokes
from .figure import PlaceFigure

LIFT = 0.02
"""Metres by which the line is drawn over the floor."""


class DrawnLine:
    """A line that is drawn from a press of the mouse button to its release."""

    def __init__(self, figure: PlaceFigure) -> None:
        """figure: shows the line in the 3D view."""
        self._figure = figure
        self._points: list[np.ndarray] | None = None

    @property
    def begun(self) -> bool:
        """Whether the button is down."""
        return self._points is not None

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> bool:
        """Handle an event of the mouse; return whether the line is complete. A line without length is dropped."""
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            self._points = []
            self._go_on(context, event)
        elif event.type == "MOUSEMOVE" and self.begun:
            self._go_on(context, event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE" and self.begun:
            if len(self._points) > 1:
                return True
            self._points = None
        return False

    def add(self, context: bpy.types.Context) -> list[bpy.types.Object]:
        """Add the way-points of the complete line."""
        return strokes.add(context, self._points)

    def _go_on(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        """Add the point of the floor under the mouse."""
        point = clicking.surface_under(context, event.mouse_x, event.mouse_y)
        if point is not None:
            self._points.append(point)
            self._figure.stroke(np.array(self._points) + [0.0, 0.0, LIFT])
            self._figure.redraw(context)


def take_back(names: list[str]) -> None:
    """Delete those way-points with these names that still exist."""
    waypoints.delete([bpy.data.objects[name] for name in names if name in bpy.data.objects])
