"""Looking at takes: a sheet shows the character, in frame, and a film can be read back."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from samp_blender.samp_addon.blender.render import contact_sheet, movie, workbench  # noqa: E402
from samp_blender.samp_addon.errors import SampError  # noqa: E402
from samp_blender.samp_addon.motion import Motion  # noqa: E402
from samp_blender.training import look  # noqa: E402


def standing(frames: int = 20) -> Motion:
    root = np.zeros((frames, 3))
    root[:, 1], root[:, 2] = 0.93, np.linspace(0, 2, frames)
    rotations = np.zeros((frames, 22, 4))
    rotations[..., 0] = 1
    return Motion(root, rotations)


needs_pictures = pytest.mark.skipif(
    not workbench.offscreen_works(), reason="no libEGL: pictures cannot be rendered"
)


@needs_pictures
@pytest.mark.parametrize("follow", [False, True])
def test_sheet_shows_the_character_in_every_tile(tmp_path, follow):
    out = look.look(standing(), tmp_path / "sheet.png", follow=follow, count=6, size=(120, 120))
    sheet = workbench.read_png(out).astype(int)
    assert sheet.shape == (2 * 124 - 4, 6 * 124 - 4, 3)
    for row in range(2):
        for column in range(6):
            tile = sheet[row * 124 : row * 124 + 120, column * 124 : column * 124 + 120]
            body = np.ptp(tile, axis=-1) > 15  # the floor and the backdrop are grey
            assert 100 < body.sum() < 0.5 * body.size
            edge = np.concatenate([body[20:, 0], body[20:, -1], body[-1]])
            assert not edge.any(), "the character is cut off"


@needs_pictures
def test_sheet_leaves_the_scene_as_it_was(tmp_path):
    objects = len(bpy.context.scene.objects)
    look.look(standing(4), tmp_path / "sheet.png", count=2, size=(64, 64))
    assert len(bpy.context.scene.objects) == objects
    assert "SAMP stage" not in bpy.data.scenes
    assert not [c for c in bpy.data.cameras if c.name.startswith("SAMP look")]


@needs_pictures
def test_sheet_of_a_scene_with_shot_cameras_has_its_own_views():
    """Timeline markers that are bound to cameras switch the scene's camera in every frame."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene, motion = bpy.context.scene, standing(8)
    bpy.ops.mesh.primitive_cube_add(size=0.6, location=(0, 0, 0.9))
    track = contact_sheet.Track.of(motion)
    size, view = (48, 48), contact_sheet.VIEWS[0]

    def tiles():
        return contact_sheet.pictures(scene, track, [0, 7], lambda k: scene.frame_set(1 + k), view, size=size)

    before = tiles()
    shot = bpy.data.objects.new("Shot", bpy.data.cameras.new("Shot"))
    shot.location = (0, 0, 300)  # sees nothing
    scene.collection.objects.link(shot)
    scene.camera = shot
    marker = scene.timeline_markers.new("Shot", frame=1)
    marker.camera = shot
    np.testing.assert_array_equal(np.array(tiles()), np.array(before))
    assert np.ptp(before[0]) > 30
    assert (scene.camera, marker.camera) == (shot, shot)


def test_track_faces_where_the_hips_face():
    track = contact_sheet.Track.of(standing())
    np.testing.assert_allclose(track.front, -np.pi / 2, atol=1e-9)  # +Z of the network is -Y of Blender
    np.testing.assert_allclose(track.pelvis[-1], [0, -2, 0.93], atol=1e-9)


def test_png_is_read_back(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    workbench.write_png(tmp_path / "a.png", pixels)
    np.testing.assert_array_equal(workbench.read_png(tmp_path / "a.png"), pixels)


def test_movie_has_every_picture(tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    pictures = [np.full((64, 96, 3), 10 * k, np.uint8) for k in range(12)]
    path = movie.write_movie(tmp_path / "a.mp4", pictures, 30)
    assert imageio_ffmpeg.count_frames_and_secs(str(path))[0] == 12


def test_movie_of_nothing_is_refused(tmp_path):
    with pytest.raises(SampError, match="no picture"):
        movie.write_movie(tmp_path / "a.mp4", [], 30)


def test_cut_keeps_the_seconds_asked_for():
    assert len(look.cut(standing(61), 0.5, 1.0)) == 16
