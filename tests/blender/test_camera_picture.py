"""The picture of a camera: what it shows, what it leaves alone, and which cameras are refused."""

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon.blender.render import camera_picture
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.frames import to_network


@pytest.fixture
def context():
    """A floor, a red box of 1 m in its middle, a wall behind it, and a camera 4 m in front."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    for name, place, size, colour in (
        ("Floor", (0, 0, -0.05), (10, 10, 0.1), (0.6, 0.6, 0.6)),
        ("Box", (0, 0, 0.5), (1, 1, 1), (0.8, 0.05, 0.05)),
        ("Wall", (0, 3, 1.5), (10, 0.2, 3), (0.7, 0.7, 0.7)),
    ):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place, scale=size)
        made = bpy.context.object
        made.name = name
        material = bpy.data.materials.new(name)
        paint(material, colour)
        made.data.materials.append(material)
    add_camera("Shot", (0, -4.5, 1.0), (np.pi / 2, 0, 0))
    bpy.context.scene.camera = bpy.data.objects["Shot"]
    bpy.context.view_layer.update()
    return bpy.context


def paint(material, colour):
    material.diffuse_color = (*colour, 1)
    for node in material.node_tree.nodes if material.node_tree else ():
        if "Base Color" in node.inputs:
            node.inputs["Base Color"].default_value = (*colour, 1)


def add_camera(name, place, turn, **settings):
    data = bpy.data.cameras.new(name)
    for key, value in settings.items():
        setattr(data, key, value)
    made = bpy.data.objects.new(name, data)
    made.location, made.rotation_euler = place, turn
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.update()
    return made


def take(context, name=""):
    return camera_picture.take(context, name, read_scene.read_scene(context))


def test_depth_colour_and_projection(context):
    view = take(context)
    height, width = view.depth.shape
    assert (view.name, view.colour.shape) == ("Shot", (72, 128, 3))
    assert view.depth[height // 2 + 3, width // 2] == pytest.approx(4.0, abs=0.01)  # the box
    assert view.depth[height // 4, width // 8] == pytest.approx(7.4, abs=0.01)  # the wall
    red = view.colour[height // 2 + 3, width // 2].astype(int)
    assert red[0] > 2 * red[1]
    corner = to_network(np.array([0.5, -0.5, 1.0]))
    place, ahead = view.project(corner)
    assert ahead == pytest.approx(4.0) and place[0] > 0.5  # Blender's +X is on the right
    assert view.sees(to_network(np.array([[0, -2.0, 1.0], [0, 2.0, 0.5]]))).tolist() == [True, False]
    np.testing.assert_allclose(view.eye, to_network(np.array([0, -4.5, 1.0])), atol=1e-6)


def test_nothing_of_the_scene_is_touched(context):
    scene = context.scene
    before = (scene.render.engine, scene.render.resolution_x, scene.frame_current, scene.camera, len(bpy.data.objects),
              len(bpy.data.scenes), len(bpy.data.images))  # fmt: skip
    first, second = take(context), take(context)
    after = (scene.render.engine, scene.render.resolution_x, scene.frame_current, scene.camera, len(bpy.data.objects),
             len(bpy.data.scenes), len(bpy.data.images))  # fmt: skip
    assert before == after and (first.colour == second.colour).all()


@pytest.mark.parametrize(
    "size, fit", [((1080, 1920), "AUTO"), ((1000, 1000), "VERTICAL"), ((1920, 800), "AUTO")]
)
def test_any_format_is_inside_the_picture(context, size, fit):
    context.scene.render.resolution_x, context.scene.render.resolution_y = size
    context.scene.camera.data.sensor_fit, context.scene.camera.data.lens = fit, 40
    view = take(context)
    corners = np.array(context.scene.camera.data.view_frame(scene=context.scene))
    world = corners / -corners[:, 2:] @ np.array(context.scene.camera.matrix_world)[:3, :3].T + [0, -4.5, 1.0]
    places, _ = view.project(to_network(world))
    assert (places > -1e-4).all() and (places < np.array([1, 9 / 16]) + 1e-4).all()


@pytest.mark.parametrize(
    "name, change, message",
    [
        ("", lambda scene: setattr(scene, "camera", None), "The scene has no active camera"),
        ("Shoot", None, "There is no camera 'Shoot' in the scene; choose one of 'Shot'"),
        ("Box", None, "There is no camera 'Box' in the scene"),
        ("", lambda scene: setattr(scene.camera.data, "type", "ORTHO"), "'Shot' is orthographic"),
        ("", lambda scene: setattr(scene.camera.data, "type", "PANO"), "'Shot' is panoramic"),
        ("", lambda scene: setattr(scene.camera, "location", (0, 3, 1.5)), "inside 'Wall' or right in front"),
        (
            "",
            lambda scene: setattr(scene.camera, "rotation_euler", (np.pi, 0, 0)),
            "sees nothing of the scene",
        ),
    ],
)
def test_cameras_that_are_refused(context, name, change, message):
    if change is not None:
        change(context.scene)
        context.view_layer.update()
    with pytest.raises(SampError, match=message):
        take(context, name)


def test_a_black_room(context):
    for material in bpy.data.materials:
        paint(material, (0, 0, 0))
    with pytest.raises(SampError, match="sees only black surfaces"):
        take(context)
