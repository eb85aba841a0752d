"""What happens to takes as soon as they are baked, and the path that is drawn while Place aims."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import fakes
import numpy as np
import pytest
import sofa_room
from samp_blender.operators.place import SAMP_OT_place
from samp_blender.samp_addon.blender.placing import drawn_line
from samp_blender.samp_addon.blender.sub_goals import clicking
from samp_blender.samp_addon.methods.samp import networks

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def owner(monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    return sofa_room.build()


@pytest.mark.parametrize(("mark", "strip"), [(False, False), (True, False), (False, True), (True, True)])
def test_markers_and_strip_are_options_of_the_bake(owner, mark, strip):
    settings = bpy.context.scene.samp
    settings.mark_takes, settings.as_strip = mark, strip
    bpy.context.scene.frame_set(31)
    assert bpy.ops.samp.sit_here(target="Sofa", seed=3, hold=1.0, variants=2) == {"FINISHED"}
    takes = [bpy.data.actions[f"sit Sofa {seed}"] for seed in (3, 4)]
    names = {marker.name for marker in takes[0].pose_markers}
    assert bool(names) == mark and bool(takes[1].pose_markers) == mark
    data = owner.animation_data
    strips = [one for track in data.nla_tracks for one in track.strips]
    assert [(one.action, one.frame_start) for one in strips] == ([(takes[0], 31.0)] if strip else [])
    assert data.action == (None if strip else takes[0])


@pytest.mark.parametrize("strip", [False, True])
def test_the_frame_range_ends_with_what_is_shown(owner, strip):
    """A strip that begins at the playhead ends later than its Action."""
    settings = bpy.context.scene.samp
    settings.action, settings.target, settings.as_strip = "sit", bpy.data.objects["Sofa"], strip
    bpy.context.scene.frame_set(31)
    assert bpy.ops.samp.generate() == {"FINISHED"}
    last = round(bpy.data.actions["sit Sofa 0"].frame_range[1])
    assert bpy.context.scene.frame_end == (last + 30 if strip else last)


class Figure:
    """Stands in for the drawing into the 3D view."""

    line = None

    def stroke(self, points):
        self.line = points

    def redraw(self, context):
        pass


def event(kind, value="PRESS", at=(0, 0)):
    return SimpleNamespace(type=kind, value=value, mouse_x=at[0], mouse_y=at[1])


@pytest.fixture
def floor(monkeypatch):
    """The floor under the mouse: a pixel is a centimetre; nothing left of the window's origin."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    under = lambda context, x, y: np.array([x / 100, y / 100, 0.0]) if x >= 0 else None
    monkeypatch.setattr(clicking, "surface_under", under)


def test_a_line_needs_length_and_skips_what_is_no_floor(floor):
    line = drawn_line.DrawnLine(Figure())
    assert not line.handle(bpy.context, event("MOUSEMOVE", at=(5, 5))) and not line.begun
    line.handle(bpy.context, event("LEFTMOUSE", at=(0, 0)))
    assert line.begun and not line.handle(bpy.context, event("LEFTMOUSE", "RELEASE"))
    assert not line.begun
    line.handle(bpy.context, event("LEFTMOUSE", at=(0, 0)))
    for at in ((100, 0), (-50, 0), (200, 0)):
        assert not line.handle(bpy.context, event("MOUSEMOVE", at=at))
    assert line.handle(bpy.context, event("LEFTMOUSE", "RELEASE"))
    made = line.add(bpy.context)
    assert made[-1].location.x == pytest.approx(2.0) and min(point.location.x for point in made) >= 0


@pytest.mark.parametrize("leave", [False, True])
def test_place_draws_a_path_and_takes_it_back_when_it_is_left(floor, leave):
    screen = SimpleNamespace(
        workspace=SimpleNamespace(status_text_set=lambda text: texts.append(text)),
        scene=bpy.context.scene,
        view_layer=bpy.context.view_layer,
    )
    texts, reports = [], []
    tool = SimpleNamespace(
        _figure=Figure(), _light_up=lambda *_: None, _line=None, _path=(), _added=0,
        report=lambda kind, text: reports.append(text),
    )  # fmt: skip
    SAMP_OT_place._begin_path(tool, screen)
    steps = [event("LEFTMOUSE", at=(0, 0)), event("MOUSEMOVE", at=(90, 0)), event("MOUSEMOVE", at=(90, 90))]
    steps.append(event("ESC") if leave else event("LEFTMOUSE", "RELEASE"))
    for step in steps:
        SAMP_OT_place._draw_path(tool, screen, step)
    assert tool._line is None and "draw the path" in texts[-1]
    made = [obj.name for obj in bpy.data.objects]
    assert made == list(tool._path) and bool(made) != leave and bool(reports) != leave
    SAMP_OT_place._forget(tool, screen)
    assert not bpy.data.objects and not bpy.data.collections
