"""Place: the seat, bed or floor under the mouse lights up with the body that would be there; a click bakes it."""

from __future__ import annotations

import math
import threading
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty

from . import outcome
from .job_operator import JobOperator

if TYPE_CHECKING:
    from ..samp_addon.pipeline.job import Job
    from ..samp_addon.pipeline.placing import Spot

DRAGGED = 8
"""Pixels that the mouse moves with its button down until it turns the body."""

PATH_KEY = "D"
HINT = (
    "Click: bake   Shift Click: add a step   Drag: turn   Wheel: another way   D: draw the path   Esc: stop"
)
PATH_HINT = "Drag on the floor: draw the path   Esc: cancel the path"
WORDS = {"sit": "Sit", "lie": "Lie", "walk": "Walk"}


class SAMP_OT_place(JobOperator, bpy.types.Operator):
    """Aim at a seat, a bed or the floor, see the body that would be there, and click to bake"""

    bl_idname = "samp.place"
    bl_label = "Place"

    location: FloatVectorProperty(
        name="Location",
        description="Point on a seat, a bed or a floor",
        subtype="TRANSLATION",
        size=3,
        options={"SKIP_SAVE"},
    )
    use_yaw: BoolProperty(name="Custom Facing", description="Face a given direction", options={"SKIP_SAVE"})
    yaw: FloatProperty(
        name="Facing", description="Rotation to the left from facing -Y, seen from above", subtype="ANGLE"
    )
    choice: IntProperty(
        name="Choice",
        description="Number of the way to be there, such as lying instead of sitting; 0 is the best one",
        min=0,
        options={"SKIP_SAVE"},
    )
    add_step: BoolProperty(
        name="Add Step", description="Add a step to the list instead of baking", options={"SKIP_SAVE"}
    )

    _aiming = False
    _figure = None
    _placer = None
    _spot = None
    _hit = None
    _pressed = None
    _turned = None
    _adding = False
    _added = 0
    _line = None
    _path = ()

    def job(self, context: bpy.types.Context) -> Job:
        from ..samp_addon.ui import job_from_settings

        spot = self._spot or self._find(context)
        if self._added:
            job_from_settings.add_step(context, spot)
            self._added += 1
            return job_from_settings.job_of_steps(context)
        return job_from_settings.job_at(context, spot)

    def execute(self, context: bpy.types.Context) -> set[str]:
        if not self.add_step:
            return super().execute(context)
        return outcome.run(self, lambda: self._add(context, self._find(context)))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.app.background or self.properties.is_property_set("location"):
            return super().invoke(context, event)
        return outcome.run(self, lambda: self._aim(context), {"RUNNING_MODAL"})

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if not self._aiming:
            came = super().modal(context, event)
            if came == {"CANCELLED"}:
                self._forget(context)
            return came
        if self._line is not None:
            return self._draw_path(context, event)
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        if self._pressed is None and _over_panels(context, event):
            return {"PASS_THROUGH"}
        return self._aimed(context, event)

    def _aimed(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Handle an event over the scene: the key of the path, a click, the wheel, a move of the mouse."""
        if event.type == PATH_KEY and event.value == "PRESS" and self._pressed is None:
            self._begin_path(context)
            return {"RUNNING_MODAL"}
        if event.type == "LEFTMOUSE":
            return self._click(context, event)
        wheel = {"WHEELUPMOUSE": -1, "WHEELDOWNMOUSE": 1}.get(event.type)
        if wheel is not None and not event.ctrl:
            self.choice = (self.choice + wheel) % (self._spot.choices if self._spot is not None else 1)
            self._look(context, event)
            return {"RUNNING_MODAL"}
        if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
            self._move(context, event)
        return {"PASS_THROUGH"} if self._pressed is None else {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        if self._aiming:
            self._end(context)
        else:
            super().cancel(context)
        self._forget(context)

    def _begin_path(self, context: bpy.types.Context) -> None:
        """Draw the path of the take with the mouse, from the next press of its button to the release."""
        from ..samp_addon.blender.placing import drawn_line

        self._light_up(context, None)
        self._line = drawn_line.DrawnLine(self._figure)
        context.workspace.status_text_set(PATH_HINT)

    def _draw_path(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Handle an event while the path is drawn; aim again once it is complete or cancelled."""
        cancelled = event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS"
        complete = not cancelled and self._line.handle(context, event)
        if complete:
            made = self._line.add(context)
            self._path += tuple(point.name for point in made)
            self.report({"INFO"}, f"Added {len(made)} way-points.")
        if complete or cancelled:
            self._line = None
            self._figure.stroke(None)
            context.workspace.status_text_set(HINT)
            self._figure.redraw(context)
        return {"RUNNING_MODAL"} if event.type in {"LEFTMOUSE", "ESC", "RIGHTMOUSE"} else {"PASS_THROUGH"}

    def _forget(self, context: bpy.types.Context) -> None:
        """Remove the steps and way-points that were added since the tool was started."""
        from ..samp_addon.blender.placing import drawn_line

        drawn_line.take_back(list(self._path))
        self._path = ()
        steps = context.scene.samp.steps
        for _ in range(self._added):
            steps.remove(len(steps) - 1)
        self._added = 0

    def _find(self, context: bpy.types.Context) -> Spot:
        """Return the spot at the location. Raise SampError where no body fits."""
        from ..samp_addon.blender.placing import reading
        from ..samp_addon.errors import SampError
        from ..samp_addon.ui import job_from_settings

        placer = reading.read(
            context, job_from_settings.owner(context), job_from_settings.postures_at(context)
        )
        placer.survey()
        spot = reading.at_point(placer, self.location, self.choice, self.yaw if self.use_yaw else None)
        if spot is None:
            raise SampError("There is nothing at this location; give a point on a seat, a bed or a floor.")
        if not spot.fits:
            raise SampError(spot.reason)
        return spot

    def _add(self, context: bpy.types.Context, spot: Spot) -> str:
        from ..samp_addon.ui import job_from_settings

        job_from_settings.add_step(context, spot)
        return f"Added a step: {_sentence(spot)}."

    def _aim(self, context: bpy.types.Context) -> str:
        """Read the scene, and follow the mouse from now on."""
        from ..samp_addon.blender.placing import figure, reading
        from ..samp_addon.blender.rigs import performers
        from ..samp_addon.ui import job_from_settings

        owner = job_from_settings.owner(context)
        self._placer = reading.read(context, owner, job_from_settings.postures_at(context))
        threading.Thread(target=self._placer.survey, daemon=True).start()
        self._figure = figure.PlaceFigure(None if owner is None else performers.body_of(owner))
        self._aiming, self._added, self._path = True, 0, ()
        context.window.cursor_modal_set("CROSSHAIR")
        context.workspace.status_text_set(HINT)
        context.window_manager.modal_handler_add(self)
        return ""

    def _move(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        from ..samp_addon.blender.placing import reading

        at = event.mouse_x, event.mouse_y
        if self._pressed is None:
            self._look(context, event)
        elif (
            self._spot is not None
            and max(abs(a - b) for a, b in zip(at, self._pressed, strict=True)) > DRAGGED
        ):
            self._turned = reading.facing(context, self._spot, *at)
            self._light_up(context, self._placer.at(self._hit, self.choice, self._turned))

    def _look(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        from ..samp_addon.blender.placing import reading

        at, before = (event.mouse_x, event.mouse_y), self._spot
        spot, self._hit = reading.under_mouse(context, self._placer, *at, self.choice)
        if self.choice and spot is not None and before is not None and spot.target != before.target:
            self.choice, spot = 0, self._placer.at(self._hit)
        self._light_up(context, spot)

    def _light_up(self, context: bpy.types.Context, spot: Spot | None) -> None:
        self._spot = spot
        piece, floor = self._placer.shown(spot) if spot is not None else (None, 0.0)
        self._figure.show(spot, piece, floor)
        if spot is None:
            context.workspace.status_text_set(HINT)
        elif spot.fits:
            ways = f" ({self.choice % spot.choices + 1} of {spot.choices})" if spot.choices > 1 else ""
            context.workspace.status_text_set(f"{_sentence(spot)}{ways}   {HINT}")
        else:
            context.workspace.status_text_set(f"{spot.reason}   {HINT}")
        self._figure.redraw(context)

    def _click(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Begin to turn when the button goes down; bake, or add a step, when it goes up."""
        if event.value == "PRESS":
            self._look(context, event)
            self._pressed, self._turned = (event.mouse_x, event.mouse_y), None
            self._adding = event.shift
            return {"RUNNING_MODAL"}
        if event.value != "RELEASE" or self._pressed is None:
            return {"RUNNING_MODAL"}
        self._pressed, spot = None, self._spot
        if spot is None or not spot.fits:
            self.report({"WARNING"}, "There is nothing here." if spot is None else spot.reason)
            return {"RUNNING_MODAL"}
        if self._adding or event.shift:  # Shift may be let go of before the button is
            self.report({"INFO"}, self._add(context, spot))
            self._added += 1
            return {"RUNNING_MODAL"}
        self._end(context)
        came = self.start_work(context, handled=True)
        if came == {"CANCELLED"}:
            self._forget(context)
        return came

    def _end(self, context: bpy.types.Context) -> None:
        self._aiming = False
        self._figure.remove()
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        self._figure.redraw(context)


def _sentence(spot: Spot) -> str:
    if not spot.target:
        return f"{WORDS[spot.action]} here"
    posture = f", {spot.posture.replace('_', ' ')}" if spot.posture else ""
    return f"{WORDS[spot.action]} on '{spot.target}'{posture}, facing {math.degrees(spot.yaw):.0f} degrees"


def _over_panels(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Whether the mouse is over a sidebar, a toolbar or a header, or outside of all 3D views."""
    for area in context.window.screen.areas:
        for region in area.regions:
            inside = (
                0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height
            )
            if inside and area.type == "VIEW_3D" and region.type != "WINDOW" and region.width > 1:
                return True
    return not any(
        area.type == "VIEW_3D"
        and 0 <= event.mouse_x - area.x < area.width
        and 0 <= event.mouse_y - area.y < area.height
        for area in context.window.screen.areas
    )
