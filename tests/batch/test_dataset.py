"""What a take leaves for data sets: joints and labels of each frame, and what a camera sees."""

from __future__ import annotations

import json

import bpy
import fakes
import numpy as np
import pytest
import rooms
from mathutils import Vector
from samp_blender.samp_addon import skeleton
from samp_blender.samp_addon.batch import main
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.blender.dataset import grey_png, labels, pictures
from samp_blender.samp_addon.blender.render import workbench
from samp_blender.samp_addon.body import amass, human
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.scene.geometry import SceneGeometry

STILL = np.tile([1.0, 0.0, 0.0, 0.0], (4, 22, 1))


def square(height, half):
    """Two triangles of a level square around the origin, network frame."""
    x, z = np.array([-1, 1, 1, -1]) * half, np.array([-1, -1, 1, 1]) * half
    corners = np.stack([x, np.full(4, height), z], -1)
    return np.array([corners[[0, 2, 1]], corners[[0, 3, 2]]])


@pytest.mark.parametrize(
    ("squares", "support", "contacts"),
    [
        ({"Ground": (0.0, 2.0)}, "Ground", {"right_foot": "Ground", "left_foot": "Ground"}),
        ({"Low": (-0.2, 2.0)}, None, {}),
        ({}, None, {}),
    ],
)
def test_what_carries_a_standing_body(squares, support, contacts):
    body = human.load()
    motion = Motion(np.tile([0.0, -body.floor, 0.0], (4, 1)), STILL)
    geometry = SceneGeometry.from_objects([(name, square(*size)) for name, size in squares.items()])
    found = labels.arrays(motion, geometry, body)
    name = lambda index: None if index < 0 else str(found["object_names"][index])
    assert {name(index) for index in found["support"]} == {support}
    touched = {
        str(part): name(index)
        for part, index in zip(found["contact_names"], found["contact_objects"][0], strict=True)
    }
    assert {part: what for part, what in touched.items() if what} == contacts
    assert found["joints"].shape == (4, 55, 3) and "contacts" not in found
    ankle = found["joints"][0, skeleton.INDEX["left_ankle"]]
    assert 0.03 < ankle[2] < 0.15 and ankle[0] > 0.03  # Blender's Z is up, +X is left of a body that faces -Y


@pytest.mark.parametrize(
    ("path", "begun", "phase"),
    [
        ([0, 1, 2, 2, 2], None, [0, 0, 2, 2, 2]),
        ([0, 1, 1.5, 2, 2], 2, [0, 0, 1, 2, 2]),
        ([0, 0, 0, 0, 0], None, [2] * 5),
        ([0, 1, 2, 2, 2], 4, [0, 0, 2, 2, 2]),
    ],
)
def test_phases(path, begun, phase):
    root = np.zeros((5, 3))
    root[:, 0] = path
    motion = Motion(root, np.tile(STILL[:1], (5, 1, 1)), interaction_start=begun)
    assert labels.phases(motion).tolist() == phase


def test_a_grey_picture_is_read_as_it_was_written(tmp_path):
    values = np.array([[0, 1, 255], [256, 40_000, 65_535]], dtype=np.uint16)
    grey_png.write(tmp_path / "g.png", values)
    assert read_grey(tmp_path / "g.png").tolist() == values.tolist()


def read_grey(path):
    """Return the values of a grey picture of 16 bits by Blender's reader."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.array(image.pixels[:]).reshape(height, width, -1)[::-1, :, 0]
    bpy.data.images.remove(image)
    return np.round(pixels * 65535).astype(int)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"frames": 3, "npz": "out"}, "--dataset"),
        ({"frames": 0, "dataset": "out"}, "choose from 1"),
        ({"camera": "Cam", "dataset": "out"}, "no option 'camera'"),
        ({}, "--dataset or --report"),
    ],
)
def test_options_that_do_not_fit(options, reason):
    with pytest.raises(UsageError, match=reason):
        order({"action": ["sit"], "target": ["Sofa"], **options})


def test_a_cast_has_labels_for_each_and_pictures_for_all():
    cast = [
        {"name": "Ann", "action": "sit", "target": "Sofa"},
        {"name": "Bob", "action": "sit", "target": "Sofa"},
    ]
    made = order({"cast": cast, "dataset": "out", "frames": 2, "camera": "Cam", "scene": "room.blend"})
    assert [path.name for path in made.dataset_paths().values()] == [
        "room_Ann_sit_Sofa_0.labels.npz", "room_Bob_sit_Sofa_0.labels.npz",
    ]  # fmt: skip
    assert [path.name for path in made.frame_folders().values()] == ["room_Ann_sit_Sofa_0.frames"]


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A room with a camera that sees the sofa, as a .blend, and the start of a take."""
    path = tmp_path_factory.mktemp("filmed") / "room.blend"
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    start = rooms.to_blender(rooms.random_room(1, rooms.sofa), scene)
    bpy.context.view_layer.update()
    sofa = bpy.data.objects["Sofa"]
    middle = sum((sofa.matrix_world @ Vector(corner) for corner in sofa.bound_box), Vector()) / 8
    camera = bpy.data.objects.new("Cam", bpy.data.cameras.new("Cam"))
    scene.collection.objects.link(camera)
    camera.location = middle + Vector((1.5, -2.0, 2.0))
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens, camera.data.shift_x = 24.0, 0.05
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path, [float(v) for v in start]


@pytest.fixture(scope="module")
def baked(filmed, tmp_path_factory):
    """One take with all that a data set gets, by a jobs file that is run twice; its folder and the report's entry."""
    path, start = filmed
    folder = tmp_path_factory.mktemp("baked")
    line = {"scene": str(path), "action": "sit", "target": "Sofa", "start": start, "hold": 0.5}
    line |= {"npz": str(folder / "data"), "dataset": str(folder / "data")}
    if workbench.offscreen_works():
        line |= {"frames": 2, "camera": "Cam"}
    (folder / "jobs.jsonl").write_text(json.dumps(line) + "\n")
    times = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "WIDTH", 160)
        for _ in range(2):
            options = ["--jobs", str(folder / "jobs.jsonl"), "--report", str(folder / "r.json")]
            assert main.main(options, fakes.TOOLS) == 0
            times.append({file: file.stat().st_mtime_ns for file in (folder / "data").rglob("*")})
    (variant,) = json.loads((folder / "r.json").read_text())["variants"]
    return folder / "data", variant, times


def test_the_labels_of_a_take(baked):
    folder, variant, _ = baked
    assert variant["dataset"] == str(folder / "room_sit_Sofa_0.labels.npz")
    with np.load(variant["dataset"], allow_pickle=False) as data:
        found = dict(data)
    pelvis = amass.read_amass(variant["npz"]).root
    assert found["joints"].shape == (len(pelvis), 55, 3) and found["fps"] == variant["fps"]
    np.testing.assert_allclose(found["joints"][:, 0], pelvis[:, [0, 2, 1]] * [1, -1, 1], atol=1e-3)
    assert found["phase"][-1] == 2 and found["phase"][0] == 0
    assert {"Sofa"} == {str(found["object_names"][k]) for k in found["support"][-5:]}
    assert (str(found["target"]), int(found["seed"]), str(found["scene"])) == ("Sofa", 0, "room")
    np.testing.assert_allclose(found["goal_position"], variant["goal_position"])


def test_a_second_run_writes_nothing_again(baked):
    _, _, (first, second) = baked
    assert first == second and len(first) >= 2


@pytest.mark.skipif(not workbench.offscreen_works(), reason="no libEGL: pictures cannot be rendered")
def test_the_pictures_of_a_take(baked, filmed):
    home, variant, _ = baked
    folder = home / "room_sit_Sofa_0.frames"
    index = json.loads((folder / "cameras.json").read_text())
    assert variant["frames"] == str(folder / "cameras.json") and len(list(folder.iterdir())) == 7
    assert (index["camera"], index["width"], index["height"]) == ("Cam", 160, 90)
    assert [entry["frame"] for entry in index["frames"]] == [variant["frame_start"], variant["frame_end"]]
    objects = {entry["name"]: entry for entry in index["objects"]}
    assert objects["Sofa"]["class"] == "target" and "character" in {
        each["class"] for each in index["objects"]
    }
    last = index["frames"][-1]
    colour, depth, shown = (
        workbench.read_png(folder / last["colour"]),
        read_grey(folder / last["depth"]),
        read_grey(folder / last["objects"]),
    )
    assert colour.shape == (90, 160, 3) and depth.shape == shown.shape == (90, 160)
    assert ((depth == 0) == (shown == 0)).all()

    bpy.ops.wm.open_mainfile(filepath=str(filmed[0]))
    sofa = bpy.data.objects["Sofa"]
    rows, columns = np.nonzero(shown == objects["Sofa"]["number"])
    assert len(rows) > 300
    rays = np.stack([columns + 0.5, rows + 0.5, np.ones(len(rows))], -1) @ np.linalg.inv(last["intrinsics"]).T
    local = rays * depth[rows, columns][:, None] * index["depth_unit_m"]
    turn = np.array(last["extrinsics"])
    points = (local - turn[:3, 3]) @ turn[:3, :3]
    corners = np.array([sofa.matrix_world @ Vector(corner) for corner in sofa.bound_box])
    assert (points > corners.min(0) - 0.01).all() and (points < corners.max(0) + 0.01).all()
    bodies = [each["number"] for each in index["objects"] if each["class"] == "character"]
    body = np.isin(shown, bodies)
    assert 50 < body.sum() < 5000
    # The body's pixels have other colours than the same pixels of the first frame, where it stands elsewhere.
    first = workbench.read_png(folder / index["frames"][0]["colour"])
    differ = np.abs(first.astype(int) - colour).max(-1) > 20
    assert differ[body].mean() > 0.5
